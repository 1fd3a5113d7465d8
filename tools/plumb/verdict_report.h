// What `plumb validate` says: as text, as JSON, for CI as JUnit XML, and as one page of HTML.
#pragma once

#include <string>
#include <vector>

#include "core/image.h"
#include "core/tap.h"
#include "gi/parity/verdict.h"
#include "io/manifest.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

struct StageReport {
    parity::StageVerdict verdict;
    std::vector<std::string> notes;     // what was assumed
    std::vector<TapValue> explanation;  // of the worst pixel, where not all is equal
    // Pictures, where they were asked for: of the verdicts; and of |got - expected|, where not all is equal.
    Image<std::uint32_t> map, error;
};

struct ValidationReport {
    const io::Manifest& manifest;
    std::string profile;
    double max_ambiguous = 0;
    std::vector<StageReport> stages;  // in the manifest's order

    // False where not one pixel was judged in all of them, too.
    bool passed() const;
    bool judged() const;
    parity::Verdict verdict() const;  // the worst of all stages
    // The first that did not pass; else null. What follows it may be wrong because of it in her program, not in here:
    // each stage is judged from its own dumped inputs.
    const StageReport* first_failed() const;
};

std::string validation_text(const ValidationReport& report);
Json validation_json(const ValidationReport& report);
std::string validation_junit(const ValidationReport& report);
std::string validation_html(const ValidationReport& report);

// "equal", "wrong" ...; of a stage of which no pixel was judged "nothing to judge".
std::string verdict_text(const parity::StageVerdict& verdict);
// "ideal", "ideal with 4 subpixel bits".
std::string profile_text(const ValidationReport& report);
inline constexpr const char* none_judged = "no pixel was judged";

// "12.5 %"; what is there is never shown as 0, and what is not all never as 100.
std::string share_text(std::int64_t count, std::int64_t of);
// "irradiance.x"; of an output of one channel its name.
std::string component_text(const parity::WorstPixel& worst);

}  // namespace plumb::cli
