#include "prefilters.h"

namespace dynemo {
namespace {

class NoPrefilter : public EntityPrefilter {
 public:
  FilteredPair filter(const CSceneGraph&, const LoopPair&, const PoseEstimate&) const override {
    return {};
  }
};

}  // namespace

std::unique_ptr<EntityPrefilter> makeNoPrefilter(const PrefilterParams&) {
  return std::make_unique<NoPrefilter>();
}

}  // namespace dynemo
