#include "dynemo/ingest/detections_csv.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "dynemo/core/error.h"
#include "dynemo/core/noise.h"

namespace dynemo {
namespace {

constexpr std::size_t kPoseFields = 10;
constexpr std::size_t kCovarianceTerms = 21;
/// A quaternion further from unit length than this was not meant as one.
constexpr double kQuaternionTolerance = 1e-2;
/// Smallest eigenvalue of a covariance, relative to the largest, that still counts as non-negative.
constexpr double kEigenvalueTolerance = 1e-9;

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::size_t begin = 0;
  while (true) {
    const auto comma = line.find(',', begin);
    fields.push_back(trimmed(line.substr(begin, comma - begin)));
    if (comma == std::string::npos) return fields;
    begin = comma + 1;
  }
}

template <class Number>
Number number(const std::string& field) {
  Number value{};
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size())
    throw std::invalid_argument("'" + field + "' is not a number");
  if constexpr (std::is_floating_point_v<Number>)
    if (!std::isfinite(value)) throw std::invalid_argument("'" + field + "' is not finite");
  return value;
}

Matrix6 covariance(const std::vector<std::string>& fields, std::size_t first) {
  Matrix6 cov;
  std::size_t i = first;
  for (int r = 0; r < 6; ++r)
    for (int c = r; c < 6; ++c) cov(r, c) = cov(c, r) = number<double>(fields[i++]);
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(cov, Eigen::EigenvaluesOnly);
  const double largest = solver.eigenvalues()(5);
  if (!(solver.eigenvalues()(0) >= -kEigenvalueTolerance * std::abs(largest)))
    throw std::invalid_argument("the covariance has a negative eigenvalue");
  return cov;
}

Pose3 pose(const std::vector<std::string>& fields) {
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = number<double>(fields[3 + i]);
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (std::abs(q.norm() - 1.0) > kQuaternionTolerance)
    throw std::invalid_argument("the quaternion does not have unit length");
  return {q, Vector3(v[0], v[1], v[2])};
}

/// Throws std::invalid_argument with what is wrong.
CsvDetection parseRow(const std::string& line) {
  auto fields = split(line);
  while (fields.size() > kPoseFields && fields.back().empty()) fields.pop_back();
  const std::size_t n = fields.size();
  if (n != kPoseFields && n != kPoseFields + 1 && n != kPoseFields + 1 + kCovarianceTerms)
    throw std::invalid_argument(std::to_string(n) + " fields instead of 10, 11 or 32");
  CsvDetection d;
  d.stamp = Stamp::parse(fields[0]);
  d.entity = EntityId{number<std::int64_t>(fields[1])};
  d.class_name = fields[2];
  d.T_sensor_entity = pose(fields);
  if (n > kPoseFields) d.sensor_label = fields[kPoseFields];
  if (n > kPoseFields + 1) {
    const Matrix6 parent_cov = covariance(fields, kPoseFields + 1);
    if (!parent_cov.isZero(0.0))
      d.covariance = covarianceTranslationToLocal(parent_cov, d.T_sensor_entity.R);
  }
  return d;
}

bool isHeader(const std::string& line) {
  return std::isalpha(static_cast<unsigned char>(line[0])) != 0;
}

}  // namespace

std::vector<CsvDetection> readDetectionsCsv(std::istream& in, const std::string& origin,
                                            WarningCounter& warnings) {
  std::vector<CsvDetection> rows;
  std::string line, first_error;
  bool first_content = true;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    line = trimmed(line);
    if (line.empty() || line[0] == '#') continue;
    const bool header = first_content && isHeader(line);
    first_content = false;
    if (header) continue;
    try {
      rows.push_back(parseRow(line));
    } catch (const std::invalid_argument& e) {
      const std::string where = "line " + std::to_string(number) + ": " + e.what();
      if (first_error.empty()) first_error = where;
      warnings.count("malformed line in " + origin, where);
    }
  }
  if (rows.empty())
    throw DataError(origin + ": no usable detection" +
                    (first_error.empty() ? ", the table is empty" : "; " + first_error));
  std::stable_sort(rows.begin(), rows.end(),
                   [](const CsvDetection& a, const CsvDetection& b) { return a.stamp < b.stamp; });
  return rows;
}

std::vector<CsvDetection> readDetectionsCsv(const std::filesystem::path& file,
                                            WarningCounter& warnings) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    throw DataError(file.string() + ": no such file");
  std::ifstream in(file);
  if (!in) throw DataError(file.string() + ": cannot be opened for reading");
  return readDetectionsCsv(in, file.string(), warnings);
}

}  // namespace dynemo
