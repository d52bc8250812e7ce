#include "agent_line_model.h"
#include "agent_model.h"
#include "object_model.h"

namespace dynemo {
namespace {

template <class Model>
std::unique_ptr<MotionModel> makeModel(const MotionParams& params) {
  return std::make_unique<Model>(params);
}

}  // namespace

const MotionModelRegistry& motionModels() {
  static const MotionModelRegistry registry = [] {
    MotionModelRegistry r("motion model");
    r.add("object", makeModel<ObjectModel>);
    r.add("agent", makeModel<AgentModel>);
    r.add("agent_line", makeModel<AgentLineModel>);
    return r;
  }();
  return registry;
}

}  // namespace dynemo
