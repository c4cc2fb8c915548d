#pragma once
// How near a matte and its colours come to the truth.
#include <opencv2/core.hpp>
#include <vector>

namespace rotunda::bench {

struct MatteScore {
  double overlap = 0.0;          // IoU of the pixels above half
  std::vector<float> distances;  // from each outline to the other, pixels, signed: positive where ours is too large
};
MatteScore matte_score(const cv::Mat& found, const cv::Mat& truth);

// The four pixels inside of the true outline, CV_8UC1, 255 there.
cv::Mat rim_mask(const cv::Mat& truth_matte);

// Mean difference of red, green and blue from the truth there, of 255; negative where nothing is inside.
double rim_colour_error(const cv::Mat& colours, const cv::Mat& truth_colours, const cv::Mat& truth_matte);

// Many scores' sum.
class MatteTotals {
 public:
  void add(const MatteScore& score);
  void add(const MatteTotals& other);
  std::size_t pictures() const { return overlaps_.size(); }
  double overlap() const;
  double worst_overlap() const;
  double edge() const;  // mean, pixels
  double edge_quantile(double share) const;
  double bias() const;  // signed mean of what is nearer than 2 px: farther is a piece too many or too few

 private:
  std::vector<double> overlaps_;
  std::vector<float> distances_;
};

}  // namespace rotunda::bench
