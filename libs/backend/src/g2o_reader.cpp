#include <Eigen/Eigenvalues>
#include <charconv>
#include <cmath>
#include <fstream>
#include <istream>
#include <string_view>

#include "dynemo/backend/g2o_io.h"
#include "dynemo/core/error.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "g2o_information.h"

namespace dynemo {
namespace {

/// Standard deviation of the prior that stands for FIX [m, rad].
constexpr double kFixedSigma = 1e-4;
/// A repaired matrix keeps its largest eigenvalue and has none below this fraction of it.
constexpr double kRepairedConditioning = 1e-6;

/// One record, taken apart token by token; every complaint names file and line.
class Line {
 public:
  Line(std::string_view text, const std::string& name, int number)
      : rest_(text), name_(name), number_(number) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw DataError(name_ + ": line " + std::to_string(number_) + ": " + what);
  }
  std::string_view word() {
    const auto first = rest_.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return rest_ = {};
    const auto last = std::min(rest_.find_first_of(" \t\r", first), rest_.size());
    const std::string_view token = rest_.substr(first, last - first);
    rest_.remove_prefix(last);
    return token;
  }
  std::uint64_t id() { return parse<std::uint64_t>("a vertex id"); }
  double number() {
    const double value = parse<double>("a number");
    if (!std::isfinite(value)) fail("a value is not finite");
    return value;
  }
  Pose3 pose() {
    double v[7];
    for (double& x : v) x = number();
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    if (!(q.norm() > 1e-6 && q.norm() < 1e6)) fail("the quaternion is not of unit length");
    return {q, Vector3(v[0], v[1], v[2])};
  }
  /// 21 values of the upper triangle, row by row.
  Matrix6 symmetricMatrix() {
    Matrix6 m;
    for (int r = 0; r < 6; ++r)
      for (int c = r; c < 6; ++c) m(r, c) = m(c, r) = number();
    return m;
  }
  void end() {
    if (!word().empty()) fail("more values than expected");
  }

 private:
  template <class T>
  T parse(const char* expected) {
    std::string_view token = word();
    if (token.empty()) fail(std::string("expected ") + expected + ", found the end of the line");
    if (token.front() == '+') token.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
    if (error != std::errc() || end != token.data() + token.size()) {
      fail(std::string("expected ") + expected + ", found '" + std::string(token.substr(0, 40)) +
           "'");
    }
    return value;
  }

  std::string_view rest_;
  const std::string& name_;
  int number_;
};

struct Edge {
  std::uint64_t from, to;
  Pose3 T_from_to;
  Matrix6 information;  ///< for our residual
  int line;
};

struct Records {
  std::map<std::uint64_t, Pose3> vertices;
  std::vector<Edge> edges;
  std::map<std::uint64_t, int> fixed;  ///< with the line
  std::size_t repaired = 0;
};

Matrix6 repaired(const Matrix6& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> es(information);
  const double largest = es.eigenvalues().cwiseAbs().maxCoeff();
  const Vector6 raised = es.eigenvalues().cwiseMax(kRepairedConditioning * largest);
  const Matrix6 m = es.eigenvectors() * raised.asDiagonal() * es.eigenvectors().transpose();
  return 0.5 * (m + m.transpose());
}

void readEdge(Line& line, int number, const G2oReadOptions& options, Records& records) {
  Edge edge{};
  edge.line = number;
  edge.from = line.id();
  edge.to = line.id();
  if (edge.from == edge.to)
    line.fail("an edge from vertex " + std::to_string(edge.from) + " to itself");
  edge.T_from_to = line.pose();
  edge.information = fromG2oInformation(line.symmetricMatrix());
  line.end();
  if (!squareRootInformation(edge.information)) {
    if (options.indefinite == G2oReadOptions::Indefinite::kError || edge.information.isZero(0.0)) {
      line.fail("the information matrix of edge " + std::to_string(edge.from) + " -> " +
                std::to_string(edge.to) + " is not positive definite");
    }
    edge.information = repaired(edge.information);
    ++records.repaired;
  }
  records.edges.push_back(edge);
}

void readRecord(Line& line, int number, const G2oReadOptions& options, Records& records) {
  const std::string_view tag = line.word();
  if (tag.empty() || tag.front() == '#') return;
  if (tag == "VERTEX_SE3:QUAT") {
    const std::uint64_t id = line.id();
    const Pose3 T = line.pose();
    line.end();
    if (!records.vertices.emplace(id, T).second)
      line.fail("vertex " + std::to_string(id) + " appears twice");
  } else if (tag == "EDGE_SE3:QUAT") {
    readEdge(line, number, options, records);
  } else if (tag == "FIX") {
    records.fixed.emplace(line.id(), number);
    line.end();
  } else {
    line.fail("unknown record '" + std::string(tag.substr(0, 40)) + "'");
  }
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
    if (e.to == e.from + 1) {
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
  if (records.vertices.empty()) throw DataError(name + ": holds no VERTEX_SE3:QUAT");
  G2oContents contents;
  contents.graph.apply(toDelta(records, name, contents.node_of_vertex));
  contents.repaired_edges = records.repaired;
  return contents;
}

G2oContents readG2o(const std::filesystem::path& file, const G2oReadOptions& options) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file))
    throw DataError(file.string() + ": cannot be read");
  return readG2o(in, file.string(), options);
}

}  // namespace dynemo
