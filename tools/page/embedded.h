// The files that a page is made of, put into the program when it is built (embed_files.cpp).
#pragma once

#include <string_view>

namespace plumb::page {

extern const std::string_view page_css, page_js;
extern const std::string_view chart_js, chart_licence;  // Chart.js, and the terms it comes under

}  // namespace plumb::page
