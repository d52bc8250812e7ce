#include "prefilters.h"

namespace dynemo {

const EntityPrefilterRegistry& entityPrefilters() {
  static const EntityPrefilterRegistry registry = [] {
    EntityPrefilterRegistry r("entity prefilter");
    r.add("none", makeNoPrefilter);
    r.add("always", makeAlwaysPrefilter);
    r.add("motion", makeMotionPrefilter);
    return r;
  }();
  return registry;
}

}  // namespace dynemo
