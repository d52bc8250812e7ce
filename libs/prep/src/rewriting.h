// The loop that all rewriting has in common.
#pragma once

#include "dynemo/prep/rewrite.h"

namespace dynemo {

/// What becomes of a piece: the output it goes to, or null to drop it. May edit it.
using Route = std::function<RawlogOutput*(RawlogPiece&)>;

/// Hands every piece of the input to `route`. Counts what is read and warned of.
void rewrite(PieceReader& input, const Route& route, WarningCounter& warnings,
             RewriteReport& report);

/// Input to one output through an edit of each observation, committed at the end after `check`,
/// which may throw to give the result up.
RewriteReport rewriteObservations(const std::filesystem::path& input,
                                  const std::filesystem::path& output,
                                  const RewriteOptions& options, const ObservationEdit& edit,
                                  const std::function<void(const RewriteReport&)>& check = nullptr);

/// Labels seen and labels wanted.
class LabelCheck {
 public:
  explicit LabelCheck(std::set<std::string> wanted) : wanted_(std::move(wanted)) {}
  bool wants(const std::string& label) {
    seen_.insert(label);
    return wanted_.contains(label);
  }
  /// Throws ConfigError naming the wanted labels that did not occur and those that did.
  void requireAll(const std::filesystem::path& input) const;

 private:
  std::set<std::string> wanted_, seen_;
};

}  // namespace dynemo
