// Pose graphs in g2o's text format (VERTEX_SE3:QUAT, EDGE_SE3:QUAT, FIX).
//
// g2o's residual is [t; q_xyz] of Z⁻¹ Xᵢ⁻¹ Xⱼ, ours [t; Log R] of the same product
// (edge_relative_pose.h). To first order q_xyz = ω/2, so the information changes hands as Ω = S
// Ω_g2o S with S = diag(1, 1, 1, ½, ½, ½).
#pragma once

#include <filesystem>
#include <iosfwd>
#include <map>
#include <string>

#include "dynemo/graph/scene_graph.h"

namespace dynemo {

struct G2oReadOptions {
  /// What to do with an information matrix that is not positive definite.
  enum class Indefinite {
    kError,
    kRepair  ///< raise its eigenvalues to a small fraction of the largest
  } indefinite = Indefinite::kError;
};

struct G2oContents {
  /// A keyframe per vertex, in the order of the vertices' ids; an odometry edge where the ids are
  /// consecutive, a loop closure elsewhere; a strong pose prior per FIX.
  CSceneGraph graph;
  std::map<std::uint64_t, NodeId> node_of_vertex;
  std::size_t repaired_edges = 0;
};

/// Throws DataError naming the file (or `name`), the line and what is wrong with it.
G2oContents readG2o(const std::filesystem::path& file, const G2oReadOptions& options = {});
G2oContents readG2o(std::istream& in, const std::string& name, const G2oReadOptions& options = {});

struct G2oWriteOptions {
  bool entities = false;
};

/// The graph's keyframes (and entities), the relative poses between them, and FIX for every
/// keyframe with a prior; vertices are numbered by node id. Robust kernels and other edges have no
/// place in the format. Numbers carry 17 digits: reading them back gives the same doubles.
void writeG2o(std::ostream& out, const CSceneGraph& graph, const G2oWriteOptions& options = {});

}  // namespace dynemo
