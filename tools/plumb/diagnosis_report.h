// What a diagnosis says, as text, as JSON and as a part of a page.
#pragma once

#include <string>

#include "gi/parity/diagnosis.h"
#include "tools/page/page.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

// "with irradiance times pi, 99.9 % of the pixels agree": the best guess; "" where there is none.
std::string cause_text(const parity::Diagnosis& diagnosis);
// "" and null where nothing was diagnosed.
std::string diagnosis_text(const parity::Diagnosis& diagnosis);
Json diagnosis_json(const parity::Diagnosis& diagnosis);
void diagnosis_part(page::Page& page, const parity::Diagnosis& diagnosis);

}  // namespace plumb::cli
