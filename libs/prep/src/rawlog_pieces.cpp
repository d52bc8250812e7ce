#include "dynemo/prep/rawlog_pieces.h"

#include <mrpt/obs/CSensoryFrame.h>

#include <utility>

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

using Kind = RawlogEntry::Kind;
using mrpt::obs::CObservation;
using mrpt::obs::CSensoryFrame;

/// Largest memory that one object may ask for.
constexpr std::size_t kMaxObjectBytes = std::size_t{2} << 30;

std::optional<Stamp> stampOf(const StoredObject& stored) {
  if (stored.entry.kind == Kind::kObservation)
    return validStamp(dynamic_cast<const CObservation&>(*stored.entry.object).timestamp);
  if (stored.entry.kind != Kind::kSensoryFrame) return std::nullopt;
  for (const auto& o : dynamic_cast<const CSensoryFrame&>(*stored.entry.object)) {
    const auto stamp = o ? validStamp(o->timestamp) : std::nullopt;
    if (stamp) return stamp;
  }
  return std::nullopt;
}

void editFrame(StoredObject& stored, const ObservationEdit& edit) {
  auto& frame = dynamic_cast<CSensoryFrame&>(*stored.entry.object);
  for (auto it = frame.begin(); it != frame.end();) {
    const EditResult result = *it ? edit(**it) : EditResult::kUnchanged;
    if (result != EditResult::kUnchanged) stored.edited = true;
    if (result == EditResult::kDropped)
      it = frame.erase(it);
    else
      ++it;
  }
}

}  // namespace

bool RawlogPiece::isActionsAndFrame() const {
  for (const StoredObject& stored : objects)
    if (stored.entry.kind == Kind::kActions || stored.entry.kind == Kind::kSensoryFrame)
      return true;
  return false;
}

bool editObservations(RawlogPiece& piece, const ObservationEdit& edit) {
  for (StoredObject& stored : piece.objects) {
    if (stored.entry.kind == Kind::kSensoryFrame) editFrame(stored, edit);
    if (stored.entry.kind != Kind::kObservation) continue;
    const EditResult result = edit(dynamic_cast<CObservation&>(*stored.entry.object));
    if (result == EditResult::kDropped) return false;
    if (result == EditResult::kEdited) stored.edited = true;
  }
  return true;
}

void forEachObservation(const RawlogPiece& piece, const std::function<void(CObservation&)>& visit) {
  for (const StoredObject& stored : piece.objects) {
    if (stored.entry.kind == Kind::kObservation)
      visit(dynamic_cast<CObservation&>(*stored.entry.object));
    if (stored.entry.kind == Kind::kSensoryFrame)
      for (const auto& o : dynamic_cast<const CSensoryFrame&>(*stored.entry.object))
        if (o) visit(*o);
  }
}

PieceReader::PieceReader(const std::filesystem::path& rawlog, WarningCounter& warnings)
    : file_(rawlog), reader_(rawlog, kMaxObjectBytes), warnings_(warnings) {
  reader_.keepBytes(true);
}

std::optional<StoredObject> PieceReader::read() {
  if (ahead_) return std::exchange(ahead_, std::nullopt);
  while (auto entry = reader_.next()) {
    any_ = true;
    if (entry->kind != Kind::kNull) return StoredObject{std::move(*entry)};
    warnings_.count("stored null object left out");
  }
  if (!any_) {
    throw DataError(file_.string() + ": holds no object" +
                    (reader_.damage().empty() ? "" : ": " + reader_.damage()));
  }
  if (!reader_.damage().empty() && !damage_counted_) {
    damage_counted_ = true;
    warnings_.count(file_.filename().string() +
                    ": damaged, the rest cannot be read: " + reader_.damage());
  }
  return std::nullopt;
}

std::optional<RawlogPiece> PieceReader::next() {
  auto stored = read();
  if (!stored) return std::nullopt;
  RawlogPiece piece;
  piece.stamp = stampOf(*stored);
  const bool actions = stored->entry.kind == Kind::kActions;
  piece.objects.push_back(std::move(*stored));
  if (!actions) return piece;
  auto following = read();
  if (following && following->entry.kind == Kind::kSensoryFrame) {
    piece.stamp = stampOf(*following);
    piece.objects.push_back(std::move(*following));
  } else {
    ahead_ = std::move(following);
  }
  return piece;
}

}  // namespace dynemo
