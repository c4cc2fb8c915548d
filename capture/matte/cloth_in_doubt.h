#pragma once
// What a pixel's own colour leaves open, told by what lies about it. ALGORITHMS step 2.
#include <opencv2/core.hpp>

namespace rotunda::capture {

// The performer, and of it what leads so far that it is no mixture of performer and backdrop.
struct KeyedPixels {
  cv::Mat all, firm;   // CV_8UC1, 255 inside
  cv::Mat unlit;       // CV_8UC1, 255 where it is too dark to tell
  cv::Mat bare;        // CV_8UC1, 255 where it is plainly the backdrop: no cloth is as blue as a screen
  cv::Mat lead;        // CV_32FC1, key_lead()
  cv::Mat brightness;  // CV_32FC1, ln of the backdrop's own channel against the plate's
};

// What is too dark to tell becomes performer where it borders on the performer on most sides: a fold that is open
// at the hem. A contact shadow lies along a sole, and half of it borders on the floor.
void fill_open_folds(KeyedPixels& inside);

// Doubtful pieces that end sharply become performer: an outline is as sharp as the lens, a shadow as soft as the lamps
// are wide and as what casts it is far from the backdrop.
void add_sharp_edged_cloth(KeyedPixels& inside);

// A gap between limbs that shows no backdrop of its own is as wide as its mixtures at most: what may be a mixture, but
// is wider, is cloth near the backdrop's colour. Not where nothing firm is about: there the plate is wrong.
void firm_wide_cloth(KeyedPixels& inside);

}  // namespace rotunda::capture
