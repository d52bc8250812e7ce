// A table of named factories. Each plug-in library fills its own in its register.cpp; nothing
// registers itself behind the linker's back.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynemo/core/error.h"

namespace dynemo {

template <class Base, class... Args>
class Registry {
 public:
  using Factory = std::function<std::unique_ptr<Base>(Args...)>;

  /// `kind` names the family in messages, e.g. "motion model".
  explicit Registry(std::string kind) : kind_(std::move(kind)) {}

  void add(const std::string& name, Factory factory) { factories_[name] = std::move(factory); }

  /// Throws ConfigError, listing the known names, when there is none of that name.
  std::unique_ptr<Base> make(const std::string& name, Args... args) const {
    const auto it = factories_.find(name);
    if (it != factories_.end()) return it->second(std::forward<Args>(args)...);
    std::string known;
    for (const auto& [key, factory] : factories_) known += (known.empty() ? "" : ", ") + key;
    throw ConfigError("unknown " + kind_ + " '" + name + "'; known: " + known);
  }

  bool contains(const std::string& name) const { return factories_.contains(name); }

  std::vector<std::string> names() const {
    std::vector<std::string> list;
    for (const auto& [key, factory] : factories_) list.push_back(key);
    return list;
  }

 private:
  std::string kind_;
  std::map<std::string, Factory> factories_;
};

}  // namespace dynemo
