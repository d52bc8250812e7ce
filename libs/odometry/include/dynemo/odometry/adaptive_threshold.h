// How far predictions are usually off.
#pragma once

namespace dynemo {

/// Root mean square, with exponential forgetting, of the displacements that wrong predictions cause
/// to the points of a scan (after Vizzo et al., "KISS-ICP", RA-L 2023, Eq. 4–6, with the scan's
/// mean range for its maximum).
class AdaptiveThreshold {
 public:
  AdaptiveThreshold(double initial_sigma_m, double memory);
  /// A prediction was wrong by this translation and rotation, for points at mean_range_m.
  void add(double translation_m, double rotation_rad, double mean_range_m);
  double sigma_m() const;

 private:
  double mean_square_m2_;
  double memory_;
};

}  // namespace dynemo
