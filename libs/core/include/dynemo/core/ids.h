// Strongly typed identifiers, so that a node id cannot be passed where an entity id is meant.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <ostream>

namespace dynemo {

template <class Tag, class Int>
struct StrongId {
  Int value{};
  friend auto operator<=>(const StrongId&, const StrongId&) = default;
  friend std::ostream& operator<<(std::ostream& out, const StrongId& id) { return out << id.value; }
};

/// A node of the scene graph; never reused within a session.
using NodeId = StrongId<struct NodeIdTag, std::uint64_t>;
/// An edge of the scene graph; never reused within a session.
using EdgeId = StrongId<struct EdgeIdTag, std::uint64_t>;
/// A physical agent or object, as numbered by the entity file.
using EntityId = StrongId<struct EntityIdTag, std::int64_t>;

}  // namespace dynemo

template <class Tag, class Int>
struct std::hash<dynemo::StrongId<Tag, Int>> {
  std::size_t operator()(const dynemo::StrongId<Tag, Int>& id) const noexcept {
    return std::hash<Int>{}(id.value);
  }
};
