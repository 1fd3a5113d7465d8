// What `plumb validate` says: as text, as JSON, for CI as JUnit XML, and as one page of HTML.
#pragma once

#include <string>
#include <vector>

#include "core/image.h"
#include "core/tap.h"
#include "gi/parity/diagnosis.h"
#include "gi/parity/verdict.h"
#include "io/manifest.h"
#include "tools/plumb/explain_page.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

struct StageReport {
    parity::StageVerdict verdict;
    std::vector<std::string> notes;     // what was assumed
    std::string stale;                  // what is not of this export: the stage fails, whatever its verdict; else ""
    std::vector<TapValue> explanation;  // of the pixel `explained`, where not all is equal
    // Pictures, where they were asked for: of the verdicts; and of |got - expected|, where not all is equal.
    Image<std::uint32_t> map, error;
    parity::Diagnosis diagnosis = {};   // of what is wrong
    // For the page, where not all is equal: outputs as they are expected and as they were got, and the samples of that
    // pixel.
    std::vector<DrawnPicture> outputs = {}, samples = {};
    glm::ivec2 explained{0};  // the largest error where more than 0 is expected, as far as that was looked for, or the judge's worst

    bool passed() const { return decided() && verdict.passed && stale.empty(); }
    bool failed() const { return !verdict.passed || !stale.empty(); }
    bool decided() const { return verdict.decided || !stale.empty(); }  // false: neither passed nor failed
    std::string reason() const;
};

struct ValidationReport {
    const io::Manifest& manifest;
    std::string profile;
    double max_ambiguous = 0;
    std::vector<StageReport> stages;  // in the manifest's order

    // False where there was nothing to judge in any of them, too.
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

// "equal", "wrong" ...; or "nothing to judge", "not written", "stale".
std::string verdict_text(const StageReport& stage);
// "ideal", "ideal with 4 subpixel bits".
std::string profile_text(const ValidationReport& report);
// Why a report that decided nothing is none: no pixel was judged, or all that was expected is 0.
std::string none_judged(const ValidationReport& report);

// "12.5 %"; what is there is never shown as 0, and what is not all never as 100.
std::string share_text(std::int64_t count, std::int64_t of);
// Whether some of the pixels that were judged, and not all, have no more than 0 expected.
bool has_zeros(const parity::StageVerdict& verdict);
// "irradiance.x"; of an output of one channel its name.
std::string component_text(const parity::WorstPixel& worst);

}  // namespace plumb::cli
