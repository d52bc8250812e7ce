#include "tagslam_dataset.h"

#include <mrpt/io/CFileGZInputStream.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"

namespace dynemo::test {
namespace {

std::vector<std::string> split(const std::string& line, char separator) {
  std::vector<std::string> words;
  std::stringstream in(line);
  for (std::string word; std::getline(in, word, separator);) words.push_back(word);
  return words;
}

/// The lines after the header.
std::vector<std::string> dataLines(std::istream& in) {
  std::vector<std::string> lines;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    if (!line.empty()) lines.push_back(line);
  }
  return lines;
}

std::string readGz(const std::filesystem::path& file) {
  mrpt::io::CFileGZInputStream in(file.string());
  std::string text;
  std::array<char, 65536> buffer{};
  while (const std::size_t n = in.Read(buffer.data(), buffer.size())) text.append(buffer.data(), n);
  return text;
}

Stamp stampOf(const std::string& sec, const std::string& nsec) {
  return {std::stoll(sec) * 1'000'000'000 + std::stoll(nsec)};
}

Pose3 poseFrom(const std::vector<std::string>& words, std::size_t first) {
  const auto v = [&](std::size_t i) { return std::stod(words.at(first + i)); };
  return {Eigen::Quaterniond(v(6), v(3), v(4), v(5)), Vector3(v(0), v(1), v(2))};
}

Vector3 vectorFrom(const YAML::Node& node) {
  return {node["x"].as<double>(), node["y"].as<double>(), node["z"].as<double>()};
}

TagslamCamera cameraFrom(const std::string& name, const YAML::Node& node, const YAML::Node& pose) {
  TagslamCamera camera;
  camera.name = name;
  camera.tag_topic = node["tagtopic"].as<std::string>();
  if (camera.tag_topic.front() != '/') camera.tag_topic = "/" + camera.tag_topic;
  const auto intrinsics = node["intrinsics"].as<std::vector<double>>();
  const auto resolution = node["resolution"].as<std::vector<int>>();
  CameraModel& model = camera.model;
  model.fx = intrinsics.at(0);
  model.fy = intrinsics.at(1);
  model.cx = intrinsics.at(2);
  model.cy = intrinsics.at(3);
  model.width = resolution.at(0);
  model.height = resolution.at(1);
  const auto coefficients = node["distortion_coeffs"].as<std::vector<double>>();
  std::copy(coefficients.begin(), coefficients.end(), model.coefficients.begin());
  model.distortion = node["distortion_model"].as<std::string>() == "equidistant"
                         ? DistortionModel::kKannalaBrandt
                         : DistortionModel::kPlumbBob;
  camera.T_rig_camera = {expSO3(vectorFrom(pose["rotation"])), vectorFrom(pose["position"])};
  return camera;
}

std::vector<TagslamCamera> readCameras(const std::filesystem::path& folder) {
  const YAML::Node intrinsics = YAML::LoadFile((folder / "cameras.yaml").string());
  const YAML::Node poses = YAML::LoadFile((folder / "camera_poses.yaml").string());
  std::vector<TagslamCamera> cameras;
  for (const auto& entry : intrinsics) {
    const auto name = entry.first.as<std::string>();
    cameras.push_back(cameraFrom(name, entry.second, poses[name]["pose"]));
  }
  return cameras;
}

TagCornerObservation tagFrom(const std::vector<std::string>& words) {
  TagCornerObservation tag;
  tag.tag_id = std::stoi(words.at(3));
  for (std::size_t i = 0; i < 4; ++i) {
    tag.corners_px[i] = Vector2(std::stod(words.at(5 + 2 * i)), std::stod(words.at(6 + 2 * i)));
  }
  return tag;
}

std::vector<TagslamFrame> readFrames(const std::filesystem::path& folder,
                                     const std::vector<TagslamCamera>& cameras) {
  std::map<std::pair<Stamp, std::size_t>, TagslamFrame> frames;
  std::istringstream text(readGz(folder / "detections.csv.gz"));
  for (const std::string& line : dataLines(text)) {
    const auto words = split(line, ',');
    std::string topic = words.at(2);
    if (topic.front() != '/') topic = "/" + topic;
    const auto camera = std::find_if(cameras.begin(), cameras.end(),
                                     [&](const auto& c) { return c.tag_topic == topic; });
    if (camera == cameras.end()) throw DataError(folder.string() + ": unknown topic " + topic);
    const auto index = static_cast<std::size_t>(camera - cameras.begin());
    const Stamp stamp = stampOf(words.at(0), words.at(1));
    TagslamFrame& frame = frames[{stamp, index}];
    frame.stamp = stamp;
    frame.camera = index;
    frame.tags.push_back(tagFrom(words));
  }
  std::vector<TagslamFrame> ordered;
  for (auto& [key, frame] : frames) ordered.push_back(std::move(frame));
  return ordered;
}

std::map<std::string, Pose3> readReferenceLast(const std::filesystem::path& folder) {
  std::map<std::string, Pose3> poses;
  std::ifstream in(folder / "reference_tf_last.csv");
  for (const std::string& line : dataLines(in)) {
    const auto words = split(line, ',');
    poses[words.at(1)] = poseFrom(words, 5);
  }
  return poses;
}

std::map<std::string, std::map<Stamp, Pose3>> readTracks(const std::filesystem::path& folder) {
  const std::string prefix = "reference_body_";
  std::map<std::string, std::map<Stamp, Pose3>> tracks;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string stem = entry.path().stem().string();
    if (entry.path().extension() != ".tum" || !stem.starts_with(prefix)) continue;
    auto& track = tracks[stem.substr(prefix.size())];
    std::ifstream in(entry.path());
    for (std::string line; std::getline(in, line);) {
      const auto words = split(line, ' ');
      if (words.size() == 8) track[Stamp::parse(words[0])] = poseFrom(words, 1);
    }
  }
  return tracks;
}

void addSizesOfBody(const YAML::Node& body, std::map<int, double>& sizes) {
  for (const auto& tag : body["tags"]) {
    if (tag["size"]) sizes[tag["id"].as<int>()] = tag["size"].as<double>();
  }
  if (const YAML::Node board = body["board"]) {
    const int count = board["tag_rows"].as<int>() * board["tag_columns"].as<int>();
    for (int i = 0; i < count; ++i) {
      sizes[board["tag_start_id"].as<int>() + i] = board["tag_size"].as<double>();
    }
  }
}

/// Sizes given by tag, else by the default body's default.
std::map<int, double> readSizes(const std::filesystem::path& folder,
                                const std::map<std::string, Pose3>& reference) {
  const YAML::Node settings = YAML::LoadFile((folder / "tagslam.yaml").string());
  const auto default_body = settings["default_body"].as<std::string>();
  std::map<int, double> sizes;
  double default_size = 0.0;
  for (const auto& entry : settings["bodies"]) {
    for (const auto& body : entry) {
      addSizesOfBody(body.second, sizes);
      if (body.first.as<std::string>() == default_body) {
        default_size = body.second["default_tag_size"].as<double>();
      }
    }
  }
  for (const auto& [name, pose] : reference) {
    if (name.starts_with("tag_") && name != "tag_board") {
      sizes.emplace(std::stoi(name.substr(4)), default_size);
    }
  }
  return sizes;
}

/// From x right, y up, z out of the tag to x right, y down, z into it.
Pose3 turnedTag(const Pose3& T_body_tag) {
  return T_body_tag * Pose3(Vector3(1.0, -1.0, -1.0).asDiagonal(), Vector3::Zero());
}

std::string detectionLine(Stamp stamp, const EntityModel& model, const Pose3& T_rig_entity,
                          const Matrix6& tangent_covariance) {
  const Eigen::Quaterniond q = T_rig_entity.quaternion();
  std::string line = stamp.text() + "," + std::to_string(model.id.value) + "," +
                     semanticClassName(model.semantic_class);
  for (const double v :
       {T_rig_entity.t.x(), T_rig_entity.t.y(), T_rig_entity.t.z(), q.x(), q.y(), q.z(), q.w()}) {
    line += "," + exactNumber(v);
  }
  line += ",";  // no label: the pose is in the base frame
  const Matrix6 covariance = covarianceTranslationToParent(tangent_covariance, T_rig_entity.R);
  for (int i = 0; i < 6; ++i) {
    for (int k = i; k < 6; ++k) line += "," + exactNumber(covariance(i, k));
  }
  return line;
}

}  // namespace

EntityModel TagslamDataset::bodyAsEntity(EntityId id) const {
  EntityModel model;
  model.id = id;
  model.name = "body";
  model.semantic_class = SemanticClass::kAgent;
  for (const auto& [tag_id, size_m] : tag_size_m) {
    const auto tag = reference_last.find("tag_" + std::to_string(tag_id));
    if (tag == reference_last.end()) continue;
    model.tags.push_back({tag_id, size_m, turnedTag(tag->second)});
  }
  return model;
}

EntityModels TagslamDataset::tagsAsEntities() const {
  std::vector<EntityModel> models;
  for (const auto& [tag_id, size_m] : tag_size_m) {
    EntityModel model;
    model.id = EntityId{tag_id};
    model.name = "tag " + std::to_string(tag_id);
    model.tags.push_back({tag_id, size_m, Pose3()});
    models.push_back(std::move(model));
  }
  return EntityModels(std::move(models));
}

TagslamDataset readTagslam(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) throw DataError(folder.string() + ": no folder");
  TagslamDataset dataset;
  dataset.cameras = readCameras(folder);
  dataset.frames = readFrames(folder, dataset.cameras);
  dataset.reference_last = readReferenceLast(folder);
  dataset.reference_tracks = readTracks(folder);
  dataset.tag_size_m = readSizes(folder, dataset.reference_last);
  return dataset;
}

void writeDetections(const TagslamDataset& dataset, const EntityModels& models,
                     const TagPoseParams& pose, const AmbiguityParams& ambiguity,
                     std::ostream& out) {
  for (const TagslamFrame& frame : dataset.frames) {
    const TagslamCamera& camera = dataset.cameras[frame.camera];
    for (const EntityModel& model : models.all()) {
      const auto solution = solveEntityPose(model, camera.model, frame.tags, pose);
      if (!solution) continue;
      const auto resolved = resolveAmbiguity(*solution, {}, ambiguity);
      if (!resolved) continue;
      out << detectionLine(frame.stamp, model, camera.T_rig_camera * resolved->pose.T_camera_entity,
                           resolved->pose.covariance)
          << "\n";
    }
  }
}

}  // namespace dynemo::test
