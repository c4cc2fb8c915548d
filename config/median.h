#pragma once
// The middle of numbers, of an even count the upper of the two.
#include <algorithm>
#include <cstddef>
#include <vector>

namespace rotunda {

inline double median(std::vector<double> values) {  // 0 of none
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace rotunda
