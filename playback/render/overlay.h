#pragma once
// A picture laid over what is drawn, pixel for pixel: help, state, frame rate. Needs a current GLES 3 context.
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "playback/render/gl_objects.h"

namespace rotunda::playback {

class Overlay {
 public:
  Overlay();
  // CV_8UC4, RGBA with straight alpha; its top left corner goes to (x, y) of a framebuffer of width x height pixels.
  void draw(const cv::Mat& rgba, int x, int y, int width, int height);

 private:
  GlTexture texture_;
  GlProgram program_;
  GlVertexArray vertices_;
};

// Lines of text on a dark, half transparent card, CV_8UC4.
cv::Mat text_card(const std::vector<std::string>& lines);

}  // namespace rotunda::playback
