// The elimination tree of a live problem in fronts: which variables are eliminated together, and
// which others each elimination couples.
//
// A front eliminates its pivots; what it couples are its rows, all later in the order. Its parent
// is the front that eliminates the first of its rows. A factor belongs to the front that eliminates
// the first of its variables. So a change to a factor touches only the fronts on the path from
// there to the root, and everything else of the factorisation stays valid.
#pragma once

#include <span>
#include <vector>

#include "block_arena.h"
#include "cholmod_context.h"
#include "live_problem.h"

namespace dynemo::backend {

struct Front {
  /// A list in FrontTree's index pool.
  struct List {
    int begin = 0, size = 0, capacity = 0;
  };
  List pivots, rows;  ///< variables, in elimination order
  int key = 0;        ///< position of the first pivot; children have smaller ones
  int parent = -1, first_child = -1, next_sibling = -1;
  int pivot_size = 0, row_size = 0;  ///< in tangent entries
  bool dirty = false;

  // Numbers, see front_factor.h.
  BlockArena::Block panel, update;
  double half_squared_y = 0.0;
  double flops() const {
    const double p = pivot_size, n = p + row_size + 1;
    return p * p * p / 3 + p * p * (n - p) + p * (n - p) * (n - p);
  }
};

/// All variables in the order in which they are eliminated; the last `hubs` stay behind those that
/// are appended.
struct Elimination {
  std::vector<int> order;
  std::size_t hubs = 0;
};

class FrontTree {
 public:
  /// From the next build() on the first `variables` variables are coupled with each other, factor
  /// or not, and come last.
  void setClique(int variables) { clique_ = variables; }
  int clique() const { return clique_; }
  /// A fresh order of all variables: nested dissection (minimum degree when there are few), with
  /// hubs that the newest factors touch at the end.
  Elimination order(const LiveProblem& problem, CholmodContext& context) const;
  /// Lays all variables out anew. Every front is dirty then.
  void build(const LiveProblem& problem, const Elimination& elimination, CholmodContext& context);
  /// Puts the variables at the end of the order, as pivots of fronts of their own.
  void append(const LiveProblem& problem, std::span<const int> variables);

  /// Tells the tree about a factor; its front becomes dirty.
  void addFactor(const LiveProblem& problem, int factor);
  /// Before the problem forgets the factor.
  void removeFactor(const LiveProblem& problem, int factor);
  void touchFactor(const LiveProblem& problem, int factor) { touch(ownerOf(problem, factor)); }
  void touchAll();
  /// Before the problem forgets the variable, which has no factor any more.
  void removeVariable(int variable);

  /// Takes the dirty fronts and their ancestors one by one, children first, with their structure
  /// brought up to date; −1 when there is none left.
  int nextDirty(const LiveProblem& problem);

  int fronts() const { return static_cast<int>(fronts_.size()); }
  Front& front(int f) { return fronts_[f]; }
  const Front& front(int f) const { return fronts_[f]; }
  std::span<const int> list(const Front::List& l) const {
    return {pool_.data() + l.begin, static_cast<std::size_t>(l.size)};
  }
  int frontOf(int variable) const { return front_of_[variable]; }
  bool placed(int variable) const {
    return variable < static_cast<int>(front_of_.size()) && front_of_[variable] >= 0;
  }
  int position(int variable) const { return position_[variable]; }
  /// The front that the factor belongs to.
  int frontOfFactor(const LiveProblem& problem, int factor) const {
    return front_of_[ownerOf(problem, factor)];
  }
  /// Per front, whether it or one below it is dirty.
  void dirtyPaths(std::vector<char>& is_on_path) const;
  /// Factors of which the variable is the first in the order.
  template <class Visit>
  void forEachOwnedFactor(int variable, Visit visit) const {
    for (int f = first_owned_[variable]; f >= 0; f = next_owned_[f]) visit(f);
  }
  /// Every front, children first.
  std::vector<int> ascending() const;
  /// Fronts without parents, ascending.
  std::vector<int> roots() const;
  /// Flops of factorising every front.
  double flops() const;

 private:
  void touch(int variable);
  void markDirty(int front);
  int ownerOf(const LiveProblem& problem, int factor) const;
  void own(const LiveProblem& problem, int factor);
  void updateStructure(const LiveProblem& problem, int front);
  void setParent(int front, int parent);
  void store(Front::List& list, const std::vector<int>& values);
  void layOut(const LiveProblem& problem, const Elimination& elimination, CholmodContext& context);

  std::vector<Front> fronts_;
  std::vector<int> pool_;
  std::vector<int> front_of_, position_, first_owned_;
  std::vector<int> next_owned_;
  std::vector<std::pair<int, int>> dirty_;  ///< min-heap of (key, front)
  int next_position_ = 0, clique_ = 0;
  // Scratch.
  std::vector<int> stamp_, rows_;
  int current_stamp_ = 0;
};

}  // namespace dynemo::backend
