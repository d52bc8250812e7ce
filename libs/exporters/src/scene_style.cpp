#include "scene_style.h"

#include <mrpt/opengl/CText3D.h>
#include <mrpt/poses/CPose3D.h>

#include <array>
#include <cmath>
#include <numbers>

#include "entity_color.h"

namespace dynemo {

using mrpt::img::TColor;

namespace {

/// The points without those nearer than a step to their predecessor; both ends stay.
std::vector<Vector3> withLongSteps(const std::vector<Vector3>& points, double shortest_step_m) {
  std::vector<Vector3> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool far = kept.empty() || (points[i] - kept.back()).norm() >= shortest_step_m;
    if (far || i + 1 == points.size()) kept.push_back(points[i]);
  }
  return kept;
}

/// Adds the four sides of a square bar between two points.
void addBar(mrpt::opengl::CSetOfTriangles& mesh, const Vector3& from, const Vector3& to,
            double radius_m, const TColor& color) {
  const Vector3 along = to - from;
  if (!(along.norm() > 0.0)) return;
  const Vector3 any = std::abs(along.normalized().z()) < 0.9 ? Vector3::UnitZ() : Vector3::UnitX();
  const Vector3 u = radius_m * along.cross(any).normalized();
  const Vector3 v = radius_m * along.cross(u).normalized();
  const Vector3 ring[] = {u, v, -u, -v};
  for (int side = 0; side < 4; ++side) {
    const Vector3 &a = ring[side], &b = ring[(side + 1) % 4];
    for (const auto& corners : {std::array<Vector3, 3>{from + a, from + b, to + a},
                                std::array<Vector3, 3>{to + a, from + b, to + b}}) {
      mrpt::opengl::TTriangle triangle(toPoint(corners[0]).cast<float>(),
                                       toPoint(corners[1]).cast<float>(),
                                       toPoint(corners[2]).cast<float>());
      triangle.setColor(color);
      mesh.insertTriangle(triangle);
    }
  }
}

}  // namespace

mrpt::opengl::CSetOfTriangles::Ptr tube(const std::vector<Vector3>& points, double radius_m,
                                        double shortest_step_m, const TColor& color) {
  auto mesh = mrpt::opengl::CSetOfTriangles::Create();
  mesh->setColor_u8(color);
  const std::vector<Vector3> corners = withLongSteps(points, shortest_step_m);
  for (std::size_t i = 1; i < corners.size(); ++i) {
    addBar(*mesh, corners[i - 1], corners[i], radius_m, color);
  }
  return mesh;
}

TColor colorFromRgb(std::uint32_t rgb, std::uint8_t alpha) {
  return {static_cast<std::uint8_t>(rgb >> 16), static_cast<std::uint8_t>(rgb >> 8),
          static_cast<std::uint8_t>(rgb), alpha};
}

TColor entityColor(EntityId id, std::uint8_t alpha) { return colorFromRgb(entityRgb(id), alpha); }

mrpt::opengl::CSetOfObjects::Ptr label(const std::string& text, const Vector3& p_map,
                                       const TColor& color, const SceneParams& params) {
  auto letters = mrpt::opengl::CText3D::Create(text, "sans", params.text_height_m);
  letters->setColor_u8(color);
  const auto bounds = letters->getBoundingBoxLocal();
  letters->setLocation(-0.5 * (bounds.min.x + bounds.max.x), 0.0, 0.0);
  auto group = mrpt::opengl::CSetOfObjects::Create();
  group->insert(letters);
  constexpr double kDegree = std::numbers::pi / 180.0, kLean_rad = 45.0 * kDegree;
  group->setPose(mrpt::poses::CPose3D(p_map.x(), p_map.y(), p_map.z(),
                                      (params.azimuth_deg + 90.0) * kDegree, 0.0, kLean_rad));
  return group;
}

}  // namespace dynemo
