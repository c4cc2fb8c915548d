#pragma once
// Pieces of a page that is one file: text made safe, pictures inside.
#include <opencv2/core.hpp>
#include <string>
#include <string_view>

namespace rotunda::capture {

// & < > " ' as HTML and SVG want them.
std::string html_escaped(std::string_view text);

// A picture (CV_8UC1 or CV_8UC3, RGB) as the value of an <image>'s href: JPEG, so that many fit into one file.
std::string data_uri(const cv::Mat& picture, int jpeg_quality = 80);
// Bytes in base 64 (RFC 4648).
std::string base64(std::string_view bytes);

// A whole page; `body` is HTML already.
std::string html_page(std::string_view title, std::string_view body);

}  // namespace rotunda::capture
