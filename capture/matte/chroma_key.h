#pragma once
// The blue (or green) screen key: the performer's soft outline in one picture. ALGORITHMS step 2.
// Shadow on blue paint gets bluer, never less blue: a pixel belongs to the performer where red or green have gained on
// blue against the plate; only in the dark, where cloth and hair lose their hue, does the limit follow brightness.
// Around that outline a local two-colour matte finds the edge to a fraction of a pixel.
#include <opencv2/core.hpp>
#include <optional>

#include "capture/matte/backdrop_plate.h"
#include "capture/matte/matte.h"

namespace rotunda::capture {

enum class KeyMethod {
  automatic,  // chroma where the picture (or its background) shows the backdrop's colour, else difference
  chroma,
  difference  // against a background picture of any colour; shadows on it come along
};

struct ChromaKeyOptions {
  std::optional<Backdrop> backdrop;  // nothing: the colour that leads in the background, or else in the picture
  KeyMethod method = KeyMethod::automatic;
  cv::Mat stage = {};  // stage_mask.h: where the performer can be; empty: anywhere
  // held_between(): where all but the backdrop's plain colour is performer, CV_8UC1; empty: nowhere.
  cv::Mat held = {};
};

// `rgb` CV_8UC3; `background` the empty studio in the same picture, or empty: then the plate is fitted to `rgb` itself.
// The matte is empty (alpha 0) where nothing tells the performer from the backdrop. Throws InvalidInput if the sizes
// or types differ, or for KeyMethod::difference without a background.
Matte chroma_key(const cv::Mat& rgb, const ChromaKeyOptions& options = {}, const cv::Mat& background = {});

// Clean-up over time: where this camera showed the performer, three pixels deep, in the frame before and in the one
// after. What a key loses for one frame (a fold that catches the screen's light) is held by them; it takes nothing
// away, so that a limb that crosses a place within one frame stays, and a gap that opens for one frame shows the
// backdrop plainly and stays open. Nothing where either matte is empty. Throws InvalidInput if they differ in size.
cv::Mat held_between(const Matte& before, const Matte& after);

}  // namespace rotunda::capture
