#include "block_structure.h"

#include <algorithm>

namespace dynemo::backend {

BlockStructure::BlockStructure(const Connectivity& connectivity, const Adjacency& adjacency,
                               std::vector<int> order)
    : order_(std::move(order)), position_(order_.size()), tangent_offset_(order_.size()) {
  int offset = 0;
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const int v = order_[k];
    position_[v] = static_cast<int>(k);
    tangent_offset_[v] = offset;
    offset += connectivity.tangent_size[v];
    variable_at_.resize(static_cast<std::size_t>(offset), v);
  }
  layOutPanels(connectivity, adjacency);
  planTargets(connectivity);
}

void BlockStructure::layOutPanels(const Connectivity& connectivity, const Adjacency& adjacency) {
  const std::size_t n = order_.size();
  std::vector<std::vector<int>> below(n);
  for (std::size_t v = 0; v < n; ++v) {
    for (int i = adjacency.begin[v]; i < adjacency.begin[v + 1]; ++i) {
      const int p = position_[v], q = position_[adjacency.neighbors[i]];
      below[std::min(p, q)].push_back(std::max(p, q));
    }
  }
  column_begin_.push_back(0);
  panel_begin_.push_back(0);
  std::vector<int> rows;
  for (std::size_t k = 0; k < n; ++k) {
    std::sort(below[k].begin(), below[k].end());
    rows.clear();
    for (const int q : below[k]) {
      const int v = order_[q];
      panel_positions_.push_back(q);
      panel_rows_.push_back(static_cast<int>(rows.size()));
      for (int i = 0; i < connectivity.tangent_size[v]; ++i) rows.push_back(tangent_offset_[v] + i);
    }
    panel_begin_.push_back(panel_positions_.size());
    panel_height_.push_back(static_cast<int>(rows.size()));
    for (int c = 0; c < connectivity.tangent_size[order_[k]]; ++c) {
      diagonal_.push_back(rows_.size() + static_cast<std::size_t>(c));
      rows_.insert(rows_.end(), rows.begin(), rows.end());
      column_begin_.push_back(static_cast<int>(rows_.size()));
    }
  }
}

BlockStructure::Target BlockStructure::targetOf(int a, int b) const {
  const int row = std::max(position_[a], position_[b]),
            column = std::min(position_[a], position_[b]);
  const auto first = panel_positions_.begin() + static_cast<std::ptrdiff_t>(panel_begin_[column]);
  const auto last =
      panel_positions_.begin() + static_cast<std::ptrdiff_t>(panel_begin_[column + 1]);
  const auto at = std::lower_bound(first, last, row) - panel_positions_.begin();
  const int first_column = tangent_offset_[order_[column]];
  return {static_cast<std::size_t>(column_begin_[first_column] + panel_rows_[at]),
          panel_height_[column],
          row == position_[a] ? Target::Place::kDirect : Target::Place::kTransposed};
}

void BlockStructure::planTargets(const Connectivity& connectivity) {
  for (int f = 0; f < connectivity.factors(); ++f) {
    target_begin_.push_back(targets_.size());
    const auto variables = connectivity.variablesOf(f);
    for (std::size_t a = 0; a < variables.size(); ++a)
      for (std::size_t b = 0; b <= a; ++b) {
        targets_.push_back(targetOf(variables[a], variables[b]));
        if (a != b && variables[a] == variables[b]) {
          targets_.back().place = Target::Place::kSymmetrized;
        }
      }
  }
}

cholmod_sparse BlockStructure::view(double* values) const {
  return lowerTriangleView(size(), column_begin_.data(), rows_.data(), values);
}

}  // namespace dynemo::backend
