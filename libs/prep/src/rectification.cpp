#include "rectification.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace dynemo {

Rectification::Rectification(const CameraModel& c) {
  const cv::Matx33d K(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  const cv::Size size(c.width, c.height);
  if (c.distortion == DistortionModel::kKannalaBrandt) {
    const cv::Vec4d k(c.coefficients[0], c.coefficients[1], c.coefficients[2], c.coefficients[3]);
    cv::fisheye::initUndistortRectifyMap(K, k, cv::Matx33d::eye(), K, size, CV_32FC1, x_, y_);
    return;
  }
  const cv::Mat k(1, static_cast<int>(c.coefficients.size()), CV_64F,
                  const_cast<double*>(c.coefficients.data()));
  cv::initUndistortRectifyMap(K, k, cv::Matx33d::eye(), K, size, CV_32FC1, x_, y_);
}

cv::Mat Rectification::operator()(const cv::Mat& image) const {
  cv::Mat rectified;
  cv::remap(image, rectified, x_, y_, cv::INTER_LINEAR);
  return rectified;
}

}  // namespace dynemo
