#pragma once

#include "dynemo/loops/entity_prefilter.h"

namespace dynemo {

/// Both scans stay as they are.
std::unique_ptr<EntityPrefilter> makeNoPrefilter(const PrefilterParams& params);
/// Every entity leaves both scans, registered to one keyframe or to both.
std::unique_ptr<EntityPrefilter> makeAlwaysPrefilter(const PrefilterParams& params);
/// Eq. (6) and (7) of the paper per pair of keyframes.
std::unique_ptr<EntityPrefilter> makeMotionPrefilter(const PrefilterParams& params);

/// An entity that at least one keyframe of a pair has registered.
struct PairedEntity {
  const CNodeEntity* earlier = nullptr;
  const CNodeEntity* later = nullptr;
  const CNodeEntity& any() const { return later ? *later : *earlier; }
};

/// By id.
std::map<EntityId, PairedEntity> pairedEntities(const CSceneGraph& graph, const LoopPair& pair);

/// Appends a decision and, if it is to remove, the entity's points.
void decide(FilteredPair& filtered, const PairedEntity& entity, bool remove,
            const std::string& reason);

/// Sorts the indices and drops those named twice.
void finish(FilteredPair& filtered);

}  // namespace dynemo
