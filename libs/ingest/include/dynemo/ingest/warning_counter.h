// Counts what was skipped and why.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace dynemo {

/// Warnings by description. Of warnings with an example only the first one's is kept, so that the
/// table does not grow with the input.
class WarningCounter {
 public:
  void count(const std::string& what, std::uint64_t times = 1) {
    if (times > 0) counts_[what] += times;
  }
  void count(const std::string& what, const std::string& example) {
    if (example.empty()) return count(what);
    auto it = key_by_what_.find(what);
    if (it == key_by_what_.end())
      it = key_by_what_.emplace(what, what + " (first: " + example + ")").first;
    counts_[it->second] += 1;
  }
  const std::map<std::string, std::uint64_t>& counts() const { return counts_; }

 private:
  std::map<std::string, std::uint64_t> counts_;
  std::map<std::string, std::string> key_by_what_;
};

}  // namespace dynemo
