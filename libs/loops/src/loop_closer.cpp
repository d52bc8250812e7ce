#include "dynemo/loops/loop_closer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "dynemo/loops/verification.h"
#include "dynemo/matching/matcher_chain.h"

namespace dynemo {

LoopCloser::LoopCloser(const LoopParams& params)
    : LoopCloser(params, makeScanMatcher(params.matching)) {}

LoopCloser::LoopCloser(const LoopParams& params, std::unique_ptr<ScanMatcher> matcher)
    : params_(params),
      search_(params.candidates, params.entities),
      matcher_(params, std::move(matcher)),
      closures_({params.verification.probability, params.verification.drift_scale,
                 params.verification.max_chain_sigma_m}) {}

LoopCloser::~LoopCloser() = default;

std::size_t LoopCloser::closures() const {
  return static_cast<std::size_t>(std::count_if(entries_.begin(), entries_.end(),
                                                [](const Entry& e) { return e.edge.has_value(); }));
}

GraphDelta LoopCloser::close(const CSceneGraph& graph, Optimizer& optimizer) {
  GraphDelta delta;
  if (!params_.enabled) return delta;
  chain_.extend(graph);
  const Stamp now = graph.keyframes().back()->stamp;
  reviewInto(graph, now, delta);

  std::optional<Attempt> best;
  for (const LoopPair& pair : pairs(graph, optimizer)) {
    Attempt tried = attempt(graph, pair);
    if (best && !tried.isBetterThan(*best)) std::swap(*best, tried);
    if (best) reject(std::move(best->record));
    best = std::move(tried);
  }
  if (best) add(std::move(*best));
  settle(graph, now, delta);
  return delta;
}

bool LoopCloser::Attempt::isBetterThan(const Attempt& other) const {
  if (measured.has_value() != other.measured.has_value()) return measured.has_value();
  if (doubtful != other.doubtful) return !doubtful;
  return fit > other.fit;
}

void LoopCloser::reject(LoopRecord record) {
  if (record.reason.empty()) record.reason = "another candidate fits better";
  records_.push_back(std::move(record));
}

void LoopCloser::add(Attempt attempt) {
  if (!attempt.measured) return reject(std::move(attempt.record));
  const LoopCandidate& candidate = attempt.record.candidate;
  const std::size_t index =
      closures_.add({candidate.earlier, candidate.later, *attempt.measured}, chain_);
  if (attempt.doubtful) {
    closures_.doubt(index);
    reject(attempt.record);
  }
  entries_.push_back({std::move(attempt.record), attempt.explained, 0, std::nullopt});
}

GraphDelta LoopCloser::review(const CSceneGraph& graph) {
  GraphDelta delta;
  if (!params_.enabled || graph.keyframes().empty()) return delta;
  const Stamp now = graph.keyframes().back()->stamp;
  reviewInto(graph, now, delta);
  settle(graph, now, delta);
  return delta;
}

void LoopCloser::forget(const CSceneGraph& graph, NodeId keyframe) {
  if (!params_.enabled) return;
  chain_.extend(graph);
  const auto& all = graph.keyframes();
  const auto it = std::find_if(all.begin(), all.end(),
                               [&](const auto& other) { return other->id == keyframe; });
  if (it == all.end())
    throw std::out_of_range("no such keyframe to forget: " + std::to_string(keyframe.value));
  const auto index = static_cast<std::size_t>(it - all.begin());
  chain_.remove(index);
  const std::vector<bool> stays = closures_.removeKeyframe(index);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (!stays[i]) continue;
    if (kept != i) entries_[kept] = std::move(entries_[i]);
    ++kept;
  }
  entries_.erase(entries_.begin() + static_cast<std::ptrdiff_t>(kept), entries_.end());
}

std::vector<LoopPair> LoopCloser::pairs(const CSceneGraph& graph, Optimizer& optimizer) {
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (entries_[i].edge) last = std::max(last.value_or(0), closures_[i].later);
  }
  const auto candidates = search_.search(graph, chain_, last, optimizer);
  if (candidates.empty()) return {};

  const CNodeKeyframe& newest = *graph.keyframes().back();
  std::vector<const CNodeKeyframe*> others;
  for (const LoopCandidate& c : candidates) others.push_back(graph.keyframes()[c.earlier].get());
  const auto predicted = relativeEstimates(graph, optimizer, newest, others);
  if (!predicted) {
    ++warnings_["no loop search, no marginal covariance: " + predicted.error()];
    return {};
  }
  std::vector<LoopPair> pairs;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    LoopPair pair{candidates[i], others[i], &newest, (*predicted)[i], {}, {}};
    pair.shared = sharedEntities(graph, *pair.earlier, newest);
    pair.consensus = findConsensus(pair.shared, params_.entities);
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

namespace {

/// Whether two hypotheses are the same to a scan matcher.
bool isSame(const Pose3& T_a, const Pose3& T_b) {
  constexpr double kSame_m = 0.05, kSame_rad = 0.02;
  const Vector6 d = local(T_a, T_b);
  return d.head<3>().norm() < kSame_m && d.tail<3>().norm() < kSame_rad;
}

}  // namespace

LoopCloser::Attempt LoopCloser::attempt(const CSceneGraph& graph, const LoopPair& pair) {
  // Where most objects share one displacement that the robot's drift explains, they did not move:
  // it shows where to search, and their points stay (drift is not motion).
  const double max_squared = chiSquaredQuantile(6, params_.verification.probability);
  const bool drifted = pair.consensus &&
                       !isSame(pair.predicted.T, pair.consensus->earlier_later.T) &&
                       distanceFromGraph(pair.consensus->earlier_later, pair.predicted,
                                         params_.prefilter.drift_scale) <= max_squared;
  Attempt from_graph = matchFrom(graph, pair, pair.predicted, SeedOrigin::kGraph);
  verify(pair, from_graph);
  if (!drifted) return from_graph;
  Attempt from_entities =
      matchFrom(graph, pair, pair.consensus->earlier_later, SeedOrigin::kEntities);
  verify(pair, from_entities);
  return from_graph.isBetterThan(from_entities) ? from_graph : from_entities;
}

LoopCloser::Attempt LoopCloser::matchFrom(const CSceneGraph& graph, const LoopPair& pair,
                                          const PoseEstimate& seed, SeedOrigin origin) {
  Attempt attempt;
  LoopRecord& record = attempt.record;
  record.decided = pair.later->stamp;
  record.earlier = pair.earlier->id;
  record.later = pair.later->id;
  record.earlier_stamp = pair.earlier->stamp;
  record.later_stamp = pair.later->stamp;
  record.candidate = pair.candidate;
  record.seed = seed.T;
  record.seed_origin = origin;
  record.scan_points_earlier = pair.earlier->scan->cloud.size();
  record.scan_points_later = pair.later->scan->cloud.size();

  EntityAwareMatch matched = matcher_.match(graph, pair, seed);
  record.removed_earlier = matched.filtered.removed_earlier.size();
  record.removed_later = matched.filtered.removed_later.size();
  record.entities = std::move(matched.filtered.entities);
  record.seed_inlier_ratio = matched.seed_inlier_ratio;
  if (!matched.match) {
    record.reason = "no match: " + toString(matched.match.error());
    return attempt;
  }
  record.match = *matched.match;
  attempt.fit = matched.match->fit();
  attempt.range_m = matched.range_m;
  return attempt;
}

void LoopCloser::verify(const LoopPair& pair, Attempt& attempt) const {
  LoopRecord& record = attempt.record;
  if (!record.match) return;
  const double max_squared = chiSquaredQuantile(6, params_.verification.probability);
  PoseEstimate measured = honestEstimate(*record.match, attempt.range_m, params_.noise);
  const bool entities_agree =
      pair.consensus && squaredMahalanobis(measured, pair.consensus->earlier_later) <= max_squared;
  if (const auto reason = refusal(*record.match, entities_agree, params_.verification)) {
    record.reason = *reason;
    return;
  }
  record.graph_distance = distanceFromGraph(measured, pair.predicted, closures_.driftScale());
  attempt.doubtful = *record.graph_distance > max_squared;
  if (attempt.doubtful) record.reason = "contradicts the graph";
  // Objects that moved together would, too; but not by what the robot's drift explains.
  if (pair.consensus && !entities_agree &&
      distanceFromGraph(pair.consensus->earlier_later, pair.predicted, closures_.driftScale()) <=
          max_squared) {
    attempt.doubtful = true;
    record.reason = "contradicts the objects seen from both";
  }
  attempt.measured = measured;
  const double unscaled = distanceFromGraph(measured, pair.predicted, 1.0);
  attempt.explained = std::min(1.0, std::sqrt(max_squared / unscaled));
}

void LoopCloser::settle(const CSceneGraph& graph, Stamp now, GraphDelta& delta) {
  const std::vector<bool> consistent = params_.verification.pairwise
                                           ? closures_.consistent()
                                           : std::vector<bool>(closures_.size(), true);
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (entries_[i].edge && !consistent[i]) takeOut(i, now, "contradicts other closures", delta);
  }
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    Entry& entry = entries_[i];
    if (entry.edge || closures_.discarded(i)) continue;
    if (consistent[i]) {
      insert(i, now, graph, delta);
    } else if (entry.record.reason.empty()) {
      entry.record.reason = "contradicts other closures";
      records_.push_back(entry.record);
    }
  }
}

namespace {

/// Of the graph's estimates from what the edge says, in standard deviations.
double deviation(const CEdgeRelativePose& edge, const CSceneGraph& graph) {
  const Pose3 T_1_2 = graph.getNode<CNodeKeyframe>(edge.nodes[0]).T_map_base().inverse() *
                      graph.getNode<CNodeKeyframe>(edge.nodes[1]).T_map_base();
  return (edge.sqrtInformation() * local(edge.T_1_2, T_1_2)).norm();
}

}  // namespace

void LoopCloser::reviewInto(const CSceneGraph& graph, Stamp now, GraphDelta& delta) {
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (!entries_[i].edge) continue;
    const auto& slot = graph.edgeSlots()[entries_[i].edge->value];
    const double sigmas = deviation(dynamic_cast<const CEdgeLoopClosure&>(*slot), graph);
    if (sigmas <= params_.verification.max_graph_sigmas) continue;
    char reason[64];
    std::snprintf(reason, sizeof(reason), "contradicts the graph by %.1f sigma", sigmas);
    takeOut(i, now, reason, delta);
    // Perhaps the graph is wrong: others may speak for it, once.
    closures_.doubt(i);
    if (++entries_[i].contradicted > 1) closures_.discard(i);
  }
}

double LoopCloser::correlation(std::size_t index) const {
  double sharing = 1.0;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (i == index || !entries_[i].edge) continue;
    const Closure &a = closures_[index], &b = closures_[i];
    const double apart_m = std::max(chain_.pathBetween_m(a.earlier, b.earlier),
                                    chain_.pathBetween_m(a.later, b.later));
    if (apart_m < params_.noise.correlation_m) sharing += 1.0;
  }
  return sharing;
}

RobustKernel LoopCloser::kernel(const CEdgeRelativePose& edge, double explained,
                                const CSceneGraph& graph) const {
  // A kernel narrower than the drift to be closed would take every closure after a long way for an
  // outlier: it opens as far as the graph's own uncertainty explains what the closure says.
  return {params_.noise.kernel,
          std::max(params_.noise.kernel_width, explained * deviation(edge, graph))};
}

void LoopCloser::insert(std::size_t index, Stamp now, const CSceneGraph& graph, GraphDelta& delta) {
  const Closure& closure = closures_[index];
  auto edge = std::make_shared<CEdgeLoopClosure>();
  edge->id = {graph.nextEdgeId().value + delta.edges.size()};
  edge->nodes = {graph.keyframes()[closure.earlier]->id, graph.keyframes()[closure.later]->id};
  edge->T_1_2 = closure.earlier_later.T;
  edge->setCovariance(correlation(index) * closure.earlier_later.covariance);
  edge->kernel = kernel(*edge, entries_[index].explained, graph);
  delta.edges.push_back(edge);

  Entry& entry = entries_[index];
  entry.edge = edge->id;
  LoopRecord record = entry.record;
  record.decided = now;
  record.decision = LoopDecision::kAccepted;
  record.reason = entry.record.reason.empty() ? "" : "confirmed by other closures";
  record.edge = edge->id;
  records_.push_back(std::move(record));
}

void LoopCloser::takeOut(std::size_t index, Stamp now, const std::string& reason,
                         GraphDelta& delta) {
  Entry& entry = entries_[index];
  delta.removed_edges.push_back(*entry.edge);
  LoopRecord record = entry.record;
  record.decided = now;
  record.decision = LoopDecision::kRemoved;
  record.reason = reason;
  record.edge = entry.edge;
  records_.push_back(std::move(record));
  entry.edge.reset();
  entry.record.reason = reason;
  ++warnings_["loop closure taken out again"];
}

}  // namespace dynemo
