#include "prefilters.h"

namespace dynemo {
namespace {

class AlwaysPrefilter : public EntityPrefilter {
 public:
  FilteredPair filter(const CSceneGraph& graph, const LoopPair& pair,
                      const PoseEstimate&) const override {
    FilteredPair filtered;
    for (const auto& [id, entity] : pairedEntities(graph, pair))
      decide(filtered, entity, true, "always");
    finish(filtered);
    return filtered;
  }
};

}  // namespace

std::unique_ptr<EntityPrefilter> makeAlwaysPrefilter(const PrefilterParams&) {
  return std::make_unique<AlwaysPrefilter>();
}

}  // namespace dynemo
