// Which tags a recording shows, how large they are and whether they move by themselves.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/ingest/sensor_frame.h"
#include "dynemo/perception/tag_finder.h"

namespace dynemo {

struct TagSurveyParams {
  std::string family = "tag36h11";
  TagFinderParams finder{};
  /// Side of the black squares when it is known [m].
  std::optional<double> size_m{};
};

struct SurveyedTag {
  int id = 0;
  int sightings = 0;
  double min_edge_px = 0.0, max_edge_px = 0.0;
  /// Side of the black square as measured with the LiDAR points on the tag: median and number of
  /// points; empty when hardly any point hit it.
  std::optional<double> measured_size_m;
  int size_points = 0;
  /// Median speed in the odometry frame between sightings at most a second apart, given a size and
  /// odometry.
  std::optional<double> speed_m_s;
  /// The tags seen in the same image less than a metre away most often, with how often and how far.
  struct Neighbour {
    int id = 0;
    int times = 0;
    double distance_m = 0.0;
  };
  std::vector<Neighbour> neighbours;
};

class TagSurvey {
 public:
  /// Throws ConfigError for an unknown tag family.
  explicit TagSurvey(const TagSurveyParams& params);
  ~TagSurvey();
  TagSurvey(TagSurvey&&) noexcept;

  /// Takes the images of the frame; scan and odometry serve when there are any.
  void add(const SensorFrame& frame);

  std::uint64_t imagesSearched() const;
  /// By id.
  std::vector<SurveyedTag> tags() const;
  /// Median over all measured tags, which is what to take for those without a measurement.
  std::optional<double> commonSize_m() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// An entity file to edit: one entity for each tag that was seen at least `min_sightings` times,
/// with the size and the class that the survey suggests. Throws ConfigError when a size is neither
/// given nor measured.
std::string entityFileDraft(const TagSurvey& survey, const TagSurveyParams& params,
                            int min_sightings, const std::string& origin);

}  // namespace dynemo
