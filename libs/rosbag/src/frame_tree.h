#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "dynemo/core/se3.h"

namespace dynemo {

/// What the tf messages of a bag say about where frames are. Transforms that change are kept with
/// their first value and remembered as changing.
class FrameTree {
 public:
  void add(const std::string& parent, const std::string& child, const Pose3& T_parent_child);

  bool knows(const std::string& frame) const;
  /// Empty when the tree does not connect the two.
  std::optional<Pose3> find(const std::string& a, const std::string& b) const;
  /// Whether a transform on the way from a to b changes over time.
  bool changes(const std::string& a, const std::string& b) const;

  /// tf accepts names with and without a leading '/'.
  static std::string normalized(const std::string& frame) {
    return !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
  }

 private:
  struct Link {
    std::string parent;
    Pose3 T_parent_child;
    bool changes = false;
  };
  /// Links from the frame up to its root; stops when it comes around in a circle.
  std::vector<const Link*> up(const std::string& frame) const;

  std::map<std::string, Link> links_;  ///< by child
  std::set<std::string> frames_;
};

}  // namespace dynemo
