#include "written_log.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "dynemo/ingest/rawlog_reader.h"

namespace dynemo::test {

std::vector<WrittenObservation> readLog(const std::filesystem::path& rawlog) {
  RawlogReader reader(rawlog, std::size_t{1} << 30);
  reader.keepBytes(true);
  std::vector<WrittenObservation> log;
  while (auto entry = reader.next()) {
    auto o = std::dynamic_pointer_cast<mrpt::obs::CObservation>(entry->object);
    if (!o) continue;
    log.push_back({entry->class_name, o->sensorLabel, validStamp(o->timestamp).value_or(Stamp{}), o,
                   entry->bytes});
  }
  EXPECT_EQ(reader.damage(), "") << rawlog;
  return log;
}

std::map<std::string, int> countByLabel(const std::vector<WrittenObservation>& log) {
  std::map<std::string, int> counts;
  for (const auto& o : log) ++counts[o.label];
  return counts;
}

std::vector<std::string> filesIn(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace dynemo::test
