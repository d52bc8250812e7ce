// Puts observations into the order of their stamps, and copes with clocks that jump.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include "dynemo/ingest/ingest_params.h"
#include "dynemo/ingest/timed_item.h"
#include "dynemo/ingest/warning_counter.h"

namespace dynemo {

/// Observations out of order by at most SyncParams::sort_window_s are sorted. One further back, or
/// further ahead than ClockParams::max_forward_jump_s, is set aside; what happens to it is decided
/// by those that follow:
///   - an observation of the old clock comes next: what was set aside were outliers, dropped and
///   counted;
///   - ClockParams::confirmations in a row agree with each other: the clock has jumped. Forwards,
///   the stamps are taken
///     as they are. Backwards, all later stamps are shifted so that time goes on one sort window
///     after the last good stamp; but if the old clock has given fewer observations than that, it
///     was the outlier, and what it gave is dropped instead as far as it has not been handed out;
///   - the log ends: a jump forwards is believed, one backwards is not.
/// All of it is counted.
class TimeOrder {
 public:
  TimeOrder(const SyncParams& sync, const ClockParams& clock, WarningCounter& warnings);

  void push(TimedItem item);
  /// No further observation comes.
  void finish();
  /// The next observation, once nothing earlier can come; stamps never decrease.
  std::optional<TimedItem> pop();

 private:
  bool isInLine(Stamp stamp, Stamp newest) const;
  void accept(TimedItem item);
  void setAside(TimedItem item);
  void dropAside();
  bool agreesWithAside(Stamp stamp) const;
  void confirmJump();
  void confirmSetBack(Stamp first);
  Stamp shifted(Stamp stamp) const { return {stamp.ns + shift_ns_}; }

  std::int64_t window_ns_, max_forward_ns_;
  std::size_t confirmations_;
  WarningCounter& warnings_;

  std::multimap<Stamp, TimedItem> sorted_;
  std::size_t large_ = 0;  ///< scans and images among them
  std::deque<TimedItem> aside_;
  std::optional<Stamp> newest_, handed_out_;
  std::uint64_t accepted_ = 0;  ///< of the present clock
  std::int64_t shift_ns_ = 0;
  bool finished_ = false;
};

}  // namespace dynemo
