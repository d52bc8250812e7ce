#include "dynemo/ingest/time_order.h"

#include <algorithm>
#include <cmath>

namespace dynemo {
namespace {

/// More within the window means that time does not progress; the oldest observation is then let go.
constexpr std::size_t kMostSorted = 4096;
constexpr std::size_t kMostSortedLarge = 256;

bool isLarge(const TimedItem& item) {
  return item.role == SensorRole::kScan || item.role == SensorRole::kImage;
}

std::int64_t nanoseconds(double seconds) { return std::llround(seconds * 1e9); }

}  // namespace

TimeOrder::TimeOrder(const SyncParams& sync, const ClockParams& clock, WarningCounter& warnings)
    : window_ns_(nanoseconds(sync.sort_window_s)),
      max_forward_ns_(nanoseconds(clock.max_forward_jump_s)),
      confirmations_(static_cast<std::size_t>(clock.confirmations)),
      warnings_(warnings) {}

bool TimeOrder::isInLine(Stamp stamp, Stamp newest) const {
  return stamp.ns >= newest.ns - window_ns_ && stamp.ns <= newest.ns + max_forward_ns_;
}

void TimeOrder::push(TimedItem item) {
  item.stamp = shifted(item.stamp);
  if (newest_ && !isInLine(item.stamp, *newest_)) {
    setAside(std::move(item));
    return;
  }
  dropAside();
  accept(std::move(item));
}

void TimeOrder::accept(TimedItem item) {
  if (handed_out_ && item.stamp < *handed_out_) {
    warnings_.count("observation older than what was already used, dropped");
    return;
  }
  if (!newest_ || item.stamp > *newest_) newest_ = item.stamp;
  ++accepted_;
  large_ += isLarge(item) ? 1 : 0;
  const Stamp stamp = item.stamp;
  sorted_.emplace(stamp, std::move(item));
}

bool TimeOrder::agreesWithAside(Stamp stamp) const {
  const Stamp last = aside_.back().stamp;
  // A sparse log may go on jumping ahead.
  if (last > *newest_) return stamp.ns >= last.ns - window_ns_;
  return isInLine(stamp, last);
}

void TimeOrder::setAside(TimedItem item) {
  if (!aside_.empty() && !agreesWithAside(item.stamp)) dropAside();
  aside_.push_back(std::move(item));
  if (aside_.size() >= confirmations_) confirmJump();
}

void TimeOrder::dropAside() {
  for (const TimedItem& item : aside_)
    warnings_.count(item.stamp < *newest_
                        ? "stamp runs backwards beyond the window, observation dropped"
                        : "stamp far ahead of the others, observation dropped");
  aside_.clear();
}

void TimeOrder::confirmJump() {
  const Stamp first =
      std::min_element(aside_.begin(), aside_.end(), [](const auto& a, const auto& b) {
        return a.stamp < b.stamp;
      })->stamp;
  const std::int64_t old_shift_ns = shift_ns_;
  if (first < *newest_)
    confirmSetBack(first);
  else
    warnings_.count("stamps jump forwards");
  accepted_ = 0;
  newest_.reset();
  auto confirmed = std::move(aside_);
  aside_.clear();
  for (TimedItem& item : confirmed) {
    item.stamp.ns += shift_ns_ - old_shift_ns;
    accept(std::move(item));
  }
}

void TimeOrder::confirmSetBack(Stamp first) {
  if (accepted_ < confirmations_) {
    warnings_.count("stamp far from those that follow, observation dropped", sorted_.size());
    sorted_.clear();
    large_ = 0;
    newest_ = handed_out_;
  }
  if (!newest_ || first > *newest_) return;
  shift_ns_ += newest_->ns + std::max<std::int64_t>(window_ns_, 1) - first.ns;
  warnings_.count("clock set back: later stamps shifted so that time goes on");
}

void TimeOrder::finish() {
  if (!aside_.empty() && newest_ && aside_.front().stamp > *newest_)
    confirmJump();
  else
    dropAside();
  finished_ = true;
}

std::optional<TimedItem> TimeOrder::pop() {
  if (sorted_.empty()) return std::nullopt;
  const auto oldest = sorted_.begin();
  const bool certain = finished_ || oldest->first.ns <= newest_->ns - window_ns_;
  const bool too_many = sorted_.size() > kMostSorted || large_ > kMostSortedLarge;
  if (!certain && !too_many) return std::nullopt;
  handed_out_ = oldest->first;
  TimedItem item = std::move(oldest->second);
  sorted_.erase(oldest);
  large_ -= isLarge(item) ? 1 : 0;
  return item;
}

}  // namespace dynemo
