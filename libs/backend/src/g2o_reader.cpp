#include <Eigen/Eigenvalues>
#include <fstream>
#include <istream>
#include <string_view>

#include "dynemo/backend/g2o_io.h"
#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "g2o_edge.h"
#include "g2o_information.h"
#include "g2o_line.h"

namespace dynemo {
namespace {

using backend::Line;

/// Standard deviation of the prior that stands for FIX [m, rad].
constexpr double kFixedSigma = 1e-4;
/// A repaired matrix keeps its largest eigenvalue and has none below this fraction of it.
constexpr double kRepairedConditioning = 1e-6;

struct Edge {
  std::uint64_t from, to;
  Pose3 T_from_to;
  Matrix6 information;  ///< as the residual has it
  bool g2o_residual;
  int line;
};

struct Records {
  std::map<std::uint64_t, Pose3> vertices;
  std::vector<Edge> edges;
  std::map<std::uint64_t, int> fixed;  ///< with the line
  std::map<std::uint64_t, std::uint64_t> same_as;
  std::size_t repaired = 0;
};

Matrix6 repaired(const Matrix6& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> es(information);
  const double largest = es.eigenvalues().cwiseAbs().maxCoeff();
  const Vector6 raised = es.eigenvalues().cwiseMax(kRepairedConditioning * largest);
  const Matrix6 m = es.eigenvectors() * raised.asDiagonal() * es.eigenvectors().transpose();
  return 0.5 * (m + m.transpose());
}

/// The matrix of the file when it is positive definite; repaired, when asked for, if it is not.
Matrix6 checked(const Matrix6& information, const Edge& edge, const Line& line,
                const G2oReadOptions& options, Records& records) {
  if (squareRootInformation(information)) return information;
  if (options.indefinite == G2oReadOptions::Indefinite::kError || information.isZero(0.0)) {
    line.fail("the information matrix of edge " + std::to_string(edge.from) + " -> " +
              std::to_string(edge.to) + " is not positive definite");
  }
  ++records.repaired;
  return repaired(information);
}

Edge readEnds(Line& line, int number) {
  Edge edge{};
  edge.line = number;
  edge.from = line.id();
  edge.to = line.id();
  if (edge.from == edge.to)
    line.fail("an edge from vertex " + std::to_string(edge.from) + " to itself");
  return edge;
}

void readQuaternionEdge(Line& line, int number, const G2oReadOptions& options, Records& records) {
  Edge edge = readEnds(line, number);
  edge.T_from_to = line.pose();
  edge.g2o_residual = options.residual == G2oReadOptions::Residual::kG2o;
  const Matrix6 m = line.symmetricMatrix();
  line.end();
  edge.information =
      checked(edge.g2o_residual ? m : fromG2oInformation(m), edge, line, options, records);
  records.edges.push_back(edge);
}

/// Information of (x, y, z, roll, pitch, yaw), to that of our tangent.
Matrix6 fromAngleInformation(const Pose3& T, const Matrix6& information) {
  static constexpr int kMrptOrder[6] = {0, 1, 2, 5, 4, 3};
  const Matrix6 covariance = information.inverse();
  mrpt::math::CMatrixDouble66 mrpt;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) mrpt(kMrptOrder[r], kMrptOrder[c]) = covariance(r, c);
  const Matrix6 m = covarianceFromMrpt(T, mrpt).inverse();
  return 0.5 * (m + m.transpose());
}

void readAngleEdge(Line& line, int number, const G2oReadOptions& options, Records& records) {
  Edge edge = readEnds(line, number);
  edge.T_from_to = line.poseOfAngles();
  const Matrix6 m = line.atEnd() ? Matrix6(Matrix6::Identity()) : line.symmetricMatrix();
  line.end();
  edge.information = fromAngleInformation(edge.T_from_to, checked(m, edge, line, options, records));
  records.edges.push_back(edge);
}

void readVertex(Line& line, bool angles, Records& records) {
  const std::uint64_t id = line.id();
  const Pose3 T = angles ? line.poseOfAngles() : line.pose();
  line.end();
  if (!records.vertices.emplace(id, T).second)
    line.fail("vertex " + std::to_string(id) + " appears twice");
}

void readRecord(Line& line, int number, const G2oReadOptions& options, Records& records) {
  const std::string_view tag = line.word();
  if (tag.empty() || tag.front() == '#') return;
  if (tag == "VERTEX_SE3:QUAT" || tag == "VERTEX3") {
    readVertex(line, tag == "VERTEX3", records);
  } else if (tag == "EDGE_SE3:QUAT") {
    readQuaternionEdge(line, number, options, records);
  } else if (tag == "EDGE3") {
    readAngleEdge(line, number, options, records);
  } else if (tag == "FIX") {
    records.fixed.emplace(line.id(), number);
    line.end();
  } else if (tag == "EQUIV") {
    const std::uint64_t a = line.id(), b = line.id();
    line.end();
    if (a != b) records.same_as[std::max(a, b)] = std::min(a, b);
  } else {
    line.fail("unknown record '" + std::string(tag.substr(0, 40)) + "'");
  }
}

/// Vertices that are said to be others disappear in them.
void mergeEquivalents(Records& records) {
  const auto resolve = [&](std::uint64_t id) {
    for (auto it = records.same_as.find(id); it != records.same_as.end();
         it = records.same_as.find(id))
      id = it->second;
    return id;
  };
  for (const auto& [id, other] : records.same_as) {
    const auto vertex = records.vertices.find(id);
    if (vertex == records.vertices.end()) continue;
    records.vertices.emplace(resolve(id), vertex->second);
    records.vertices.erase(vertex);
  }
  for (Edge& edge : records.edges) {
    edge.from = resolve(edge.from);
    edge.to = resolve(edge.to);
  }
  std::erase_if(records.edges, [](const Edge& edge) { return edge.from == edge.to; });
}

GraphDelta toDelta(const Records& records, const std::string& name,
                   std::map<std::uint64_t, NodeId>& node_of) {
  GraphDelta delta;
  for (const auto& [id, T] : records.vertices) {
    auto node = std::make_shared<CNodeKeyframe>();
    node->id = {delta.nodes.size()};
    node->frame_index = id;
    node->T_map_node = node->T_map_node_first = node->T_odom_base = T;
    node_of[id] = node->id;
    delta.nodes.push_back(node);
  }
  const auto find = [&](std::uint64_t id, int line) {
    const auto it = node_of.find(id);
    if (it == node_of.end()) Line("", name, line).fail("there is no vertex " + std::to_string(id));
    return it->second;
  };
  const auto add = [&](const CEdgeBase::Ptr& edge, std::vector<NodeId> nodes,
                       const Matrix6& information) {
    edge->id = {delta.edges.size()};
    edge->nodes = std::move(nodes);
    edge->setInformation(information);
    delta.edges.push_back(edge);
  };
  for (const Edge& e : records.edges) {
    std::shared_ptr<CEdgeRelativePose> edge;
    if (e.g2o_residual) {
      edge = std::make_shared<backend::G2oEdge>();
    } else if (e.to == e.from + 1) {
      edge = std::make_shared<CEdgeOdometry>();
    } else {
      edge = std::make_shared<CEdgeLoopClosure>();
    }
    edge->T_1_2 = e.T_from_to;
    add(edge, {find(e.from, e.line), find(e.to, e.line)}, e.information);
  }
  for (const auto& [id, line] : records.fixed) {
    auto prior = std::make_shared<CEdgePosePrior>();
    const NodeId node = find(id, line);
    prior->T_map_node = records.vertices.at(id);
    add(prior, {node}, Matrix6::Identity() / (kFixedSigma * kFixedSigma));
  }
  return delta;
}

}  // namespace

G2oContents readG2o(std::istream& in, const std::string& name, const G2oReadOptions& options) {
  Records records;
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    Line line(text, name, number);
    readRecord(line, number, options, records);
  }
  if (in.bad()) throw DataError(name + ": cannot be read");
  if (records.vertices.empty()) throw DataError(name + ": holds no VERTEX_SE3:QUAT and no VERTEX3");
  mergeEquivalents(records);
  G2oContents contents;
  contents.graph.apply(toDelta(records, name, contents.node_of_vertex));
  contents.relative_edges = records.edges.size();
  contents.repaired_edges = records.repaired;
  contents.fixed = !records.fixed.empty();
  return contents;
}

G2oContents readG2o(const std::filesystem::path& file, const G2oReadOptions& options) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file))
    throw DataError(file.string() + ": cannot be read");
  return readG2o(in, file.string(), options);
}

}  // namespace dynemo
