// Pose graphs in the text formats of g2o (VERTEX_SE3:QUAT, EDGE_SE3:QUAT, FIX) and of MRPT and TORO
// (VERTEX3, EDGE3, EQUIV).
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
  /// Residual of EDGE_SE3:QUAT: ours, or to the letter the one that g2o minimises.
  enum class Residual { kLog, kG2o } residual = Residual::kLog;
};

struct G2oContents {
  /// A keyframe per vertex, in the order of the vertices' ids; an odometry edge where the ids are
  /// consecutive, a loop closure elsewhere; a strong pose prior per FIX.
  CSceneGraph graph;
  std::map<std::uint64_t, NodeId> node_of_vertex;
  std::size_t relative_edges = 0, repaired_edges = 0;
  bool fixed = false;  ///< some vertex is
};

/// Throws DataError naming the file (or `name`), the line and what is wrong with it. EDGE3 gives the
/// information of x, y, z, roll, pitch and yaw; all but its first six values may be missing there,
/// which means the identity.
G2oContents readG2o(const std::filesystem::path& file, const G2oReadOptions& options = {});
G2oContents readG2o(std::istream& in, const std::string& name, const G2oReadOptions& options = {});

/// The text of such a file with the poses of its vertices replaced by the graph's; everything else is
/// copied. Throws DataError like the reader.
void rewriteG2o(std::istream& in, const std::string& name, const G2oContents& contents,
                std::ostream& out);

struct G2oWriteOptions {
  bool entities = false;
};

/// The graph's keyframes (and entities), the relative poses between them, and FIX for every
/// keyframe with a prior; vertices are numbered by node id. Robust kernels and other edges have no
/// place in the format. Numbers carry 17 digits: reading them back gives the same doubles.
void writeG2o(std::ostream& out, const CSceneGraph& graph, const G2oWriteOptions& options = {});

}  // namespace dynemo
