#pragma once
// Chessboards that are too small or lie too flat for finders that look for their corners or outlines: by the middles of
// their black squares. Where light is plenty white squares swell over black ones and part their corners, and blur hides
// outlines; the middles stay where they are. A black square is a dark blob (Lindeberg 1998: a maximum of the Laplacian
// of the smoothed picture); from one that lies midway between neighbours on two lines, with white between, the lattice
// grows by local homographies (as Geiger et al. 2012 grow theirs from corners).
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace rotunda::capture {

// `grey`: CV_8UC1. The inner corners of the first lattice with the squares of a board of `inner` columns and rows of
// corners, row by row, in pixels, to a pixel or so; from which end and which side they are listed is not told. A
// lattice may lack a few squares.
std::optional<std::vector<cv::Point2f>> find_square_lattice(const cv::Mat& grey, const cv::Size& inner);

}  // namespace rotunda::capture
