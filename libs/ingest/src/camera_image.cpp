#include "camera_image.h"

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "memory_limit.h"

namespace dynemo {
namespace {

CameraModel cameraModel(const mrpt::img::TCamera& camera, const cv::Size& size) {
  CameraModel model;
  model.width = size.width;
  model.height = size.height;
  model.fx = camera.fx();
  model.fy = camera.fy();
  model.cx = camera.cx();
  model.cy = camera.cy();
  switch (camera.distortion) {
    case mrpt::img::DistortionModel::plumb_bob:
      model.distortion = DistortionModel::kPlumbBob;
      model.coefficients = camera.dist;
      break;
    case mrpt::img::DistortionModel::kannala_brandt:
      model.distortion = DistortionModel::kKannalaBrandt;
      // MRPT leaves two places between k2 and k3.
      model.coefficients = {camera.k1(), camera.k2(), camera.k3(), camera.k4()};
      break;
    case mrpt::img::DistortionModel::none:
      break;
  }
  return model;
}

bool isFinite(const CameraModel& model) {
  double sum = model.fx + model.fy + model.cx + model.cy;
  for (const double k : model.coefficients) sum += k;
  return std::isfinite(sum);
}

/// 8-bit grey version of any image; empty when its type is not supported.
cv::Mat toGrey(cv::Mat image) {
  if (image.depth() == CV_16U) image.convertTo(image, CV_8U, 1.0 / 256.0);
  if (image.depth() != CV_8U) return {};
  if (image.channels() == 1) return image.clone();
  cv::Mat grey;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  if (image.channels() == 4) cv::cvtColor(image, grey, cv::COLOR_BGRA2GRAY);
  return grey;
}

Expected<cv::Mat, DecodeFailure> greyPixels(const mrpt::img::CImage& image,
                                            const DecodeContext& context) {
  if (!image.isExternallyStored())
    return image.isEmpty() ? cv::Mat() : toGrey(image.asCvMat<cv::Mat>(mrpt::img::SHALLOW_COPY));
  const std::string name = image.getExternalStorageFile();
  const auto path = context.files.find(name);
  if (!path) return make_unexpected(DecodeFailure("image file not found", name));
  const MemoryLimit limit(static_cast<std::size_t>(context.params.max_object_mb * 1e6));
  cv::Mat grey = cv::imread(path->string(), cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  if (grey.empty()) return make_unexpected(DecodeFailure("image file cannot be read", name));
  return grey;
}

}  // namespace

Expected<CameraImage, DecodeFailure> cameraImage(const mrpt::img::CImage& pixels,
                                                 const mrpt::img::TCamera& calibration,
                                                 const Pose3& T_base_camera,
                                                 const std::string& label,
                                                 const DecodeContext& context) {
  auto grey = greyPixels(pixels, context);
  if (!grey) return make_unexpected(grey.error());
  if (grey->empty()) return make_unexpected("the image is empty or of an unsupported type");
  CameraImage image;
  image.label = label;
  image.grey = *grey;
  image.model = cameraModel(calibration, grey->size());
  image.T_base_camera = T_base_camera;
  if (!isFinite(image.model)) return make_unexpected("the camera calibration is not finite");
  if (!image.model.valid())
    context.warnings.count("image of '" + label + "' without camera calibration");
  else if (static_cast<int>(calibration.ncols) != grey->cols ||
           static_cast<int>(calibration.nrows) != grey->rows)
    context.warnings.count("image of '" + label + "' whose size is not that of its calibration");
  return image;
}

}  // namespace dynemo
