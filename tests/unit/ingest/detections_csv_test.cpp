#include "dynemo/ingest/detections_csv.h"

#include <gtest/gtest.h>

#include <sstream>

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

const char* const kHeader = "timestamp,entity_id,class,x,y,z,qx,qy,qz,qw\n";

std::vector<CsvDetection> parse(const std::string& text, WarningCounter& warnings) {
  std::istringstream in(text);
  return readDetectionsCsv(in, "table", warnings);
}

TEST(DetectionsCsv, ReadsTheShortestForm) {
  WarningCounter warnings;
  const auto rows = parse(std::string(kHeader) +
                              "1700000000.123456789,7,agent,1,2,3,0,0,0.6,0.8\r\n"
                              "# a comment\n\n"
                              "1700000000.1,-3,,1,2,3,0,0,0,1\n",
                          warnings);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_TRUE(warnings.counts().empty());
  EXPECT_EQ(rows[0].entity, EntityId{-3}) << "sorted by stamp";
  EXPECT_EQ(rows[1].stamp.ns, 1'700'000'000'123'456'789);
  EXPECT_EQ(rows[1].class_name, "agent");
  EXPECT_EQ(rows[1].T_sensor_entity.t, Vector3(1, 2, 3));
  EXPECT_NEAR(rows[1].T_sensor_entity.R(1, 0), 0.96, 1e-12);
  EXPECT_FALSE(rows[1].covariance);
  EXPECT_TRUE(rows[1].sensor_label.empty());
}

TEST(DetectionsCsv, CovarianceMovesFromTheParentsAxesToTheEntitys) {
  // The entity is turned by 90° about z, so the variance along the sensor's x is along the entity's
  // −y.
  WarningCounter warnings;
  const std::string row =
      "1,1,object,0,0,0,0,0,0.70710678,0.70710678,camera,"
      "0.04,0,0,0,0,0,"
      "0.01,0,0,0,0,"
      "0.09,0,0,0,"
      "0.001,0,0,"
      "0.002,0,"
      "0.003\n";
  const auto rows = parse(row, warnings);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].sensor_label, "camera");
  ASSERT_TRUE(rows[0].covariance);
  Vector6 expected;
  expected << 0.01, 0.04, 0.09, 0.001, 0.002, 0.003;
  EXPECT_LT((rows[0].covariance->diagonal() - expected).norm(), 1e-6);
}

TEST(DetectionsCsv, TermsAreTheUpperTriangleRowByRow) {
  WarningCounter warnings;
  const std::string row =
      "1,1,object,0,0,0,0,0,0,1,,"
      "1,0.1,0.2,0.3,0.4,0.5,"
      "2,0.6,0.7,0.8,0.9,"
      "3,0.11,0.12,0.13,"
      "4,0.14,0.15,"
      "5,0.16,"
      "6\n";
  const auto rows = parse(row, warnings);
  ASSERT_TRUE(rows.at(0).covariance);
  const Matrix6& cov = *rows[0].covariance;
  EXPECT_EQ(cov(0, 5), 0.5);
  EXPECT_EQ(cov(1, 2), 0.6);
  EXPECT_EQ(cov(3, 2), 0.11);
  EXPECT_EQ(cov(5, 4), 0.16);
  EXPECT_EQ(cov(5, 5), 6);
}

TEST(DetectionsCsv, MalformedLinesAreCountedWithTheFirstLinesNumber) {
  WarningCounter warnings;
  const auto rows = parse(std::string(kHeader) +
                              "1,1,object,1,2,3,0,0,0,1\n"
                              "2,1,object,1,2,3,0,0,0\n"        // too few
                              "x,1,object,1,2,3,0,0,0,1\n"      // no stamp
                              "3,one,object,1,2,3,0,0,0,1\n"    // no id
                              "4,1,object,nan,2,3,0,0,0,1\n"    // not finite
                              "5,1,object,1,2,3,0,0,0,0\n"      // no rotation
                              "6,1,object,1,2,3,0,0,0,1,c,1\n"  // half a covariance
                              "7,1,object,1,2,3,0,0,0,1\n",
                          warnings);
  EXPECT_EQ(rows.size(), 2U);
  ASSERT_EQ(warnings.counts().size(), 1U);
  const auto& [what, times] = *warnings.counts().begin();
  EXPECT_EQ(times, 6U);
  EXPECT_NE(what.find("first: line 3"), std::string::npos) << what;
}

TEST(DetectionsCsv, NegativeCovarianceIsMalformed) {
  WarningCounter warnings;
  EXPECT_THROW(
      parse("1,1,o,0,0,0,0,0,0,1,c,-1,0,0,0,0,0,1,0,0,0,0,1,0,0,0,1,0,0,1,0,1\n", warnings),
      DataError);
}

TEST(DetectionsCsv, NothingUsableIsAnError) {
  WarningCounter warnings;
  EXPECT_THROW(parse("", warnings), DataError);
  EXPECT_THROW(parse(kHeader, warnings), DataError);
  EXPECT_THROW(parse(std::string("\0\xFF\x01 binary\n,,,,\n", 17), warnings), DataError);
  EXPECT_THROW(readDetectionsCsv(std::filesystem::path("/nonexistent.csv"), warnings), DataError);
  try {
    parse("1,2\n", warnings);
    FAIL();
  } catch (const DataError& e) {
    EXPECT_NE(std::string(e.what()).find("line 1: 2 fields"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace dynemo
