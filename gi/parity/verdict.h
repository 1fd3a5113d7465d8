// Verdicts: whether what a device wrote is what the stage should have written, pixel by pixel.
//
//     equal          the same bits
//     within_bound   another rounding, no farther away than the device's operations may err; on our branch or another
//                    legal one whose outcome could be computed
//     ambiguous      a comparison or a choice of texel fell inside the bound, and its outcomes cannot be told apart
//     wrong          none of these; NaN on either side; a pixel that was never written
//
// Where all that is expected is 0, all that a stage reads is 0, nothing is seen or no pixel is written, there is nothing to
// judge: that is no pass.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/binding.h"
#include "core/image.h"

namespace plumb::parity {

enum class Verdict : std::uint8_t { equal, within_bound, ambiguous, wrong };
inline constexpr int verdicts = 4;
const char* verdict_name(Verdict verdict);

// One output as the device wrote it.
struct Dumped {
    std::string output;           // its name
    Array array;                  // [height][width][channels] f32 or i32, decoded
    Format stored = Format::rgba32f;  // what the device rounded it to
    unsigned channels = 15;       // bit c: component c was dumped
    // Where no Format says how the device rounded: f32 of the array's shape; the value that was stored was clamped to
    // [lowest, highest] and moved by at most this. Empty: `stored` says it.
    Array rounding = {};
    double lowest = -HUGE_VAL, highest = HUGE_VAL;
    // [height][width], or empty where all was written: 1 where the dump still holds what stood there before, 2 where its
    // file has ended. `absent` says why nothing at all was written: "out/a.bin is missing".
    std::vector<std::uint8_t> unwritten = {};
    std::string absent = "";
};

struct WorstPixel {
    glm::ivec2 pixel{0};
    Verdict verdict = Verdict::equal;
    std::string output;
    int channel = 0;
    double expected = 0, got = 0;
    double bound = 0;   // |got - expected| may be as large as this
    double excess = 0;  // |got - expected| / bound
};

struct StageVerdict {
    std::string stage, label, id;
    Verdict verdict = Verdict::equal;  // the worst of all pixels; ambiguous alone does not fail
    bool passed = false;               // nothing is wrong, and ambiguous is at most the limit
    bool decided = false;              // false: there was nothing to judge, which is neither pass nor fail
    std::string reason;                // one sentence, where it did not pass, or decided nothing
    std::array<std::int64_t, verdicts> count{};
    std::int64_t pixels = 0;           // that were judged; 0: the dispatch writes none
    std::int64_t left_out = 0;         // others that the dispatch writes, but where nothing is seen
    // Of `pixels`, where more is expected than what stands there before anything is drawn: 0, of a depth buffer what it is
    // cleared to, of integers -1; a w that is 1 everywhere is a flag, and does not count. And where the stage's images of
    // the frame's size hold more than 0, if it reads any: of nothing whatever is made is no evidence.
    std::array<std::int64_t, verdicts> nonzero_count{};
    std::int64_t nonzero = 0;
    std::int64_t unwritten = 0;        // wrong ones that were never written, and the first and last row that has some
    std::array<int, 2> unwritten_rows{};
    std::vector<WorstPixel> worst;     // the worst of each verdict first; at most JudgeOptions::worst
    Image<std::uint8_t> map;           // [height][width]: Verdict; 255: not judged
    double ms = 0;
};

struct JudgeOptions {
    DeviceProfile profile;
    double max_ambiguous = 0.005;  // share of all pixels, and of those that are not 0
    int worst = 8;
    bool until_wrong = false;      // judge no pixel after one that is wrong: counts are those of a part
    RunOptions run;
    std::vector<std::int32_t> choices;  // [height][width][n]: discrete choices that the device dumped, or empty
    int choices_a_pixel = 0;
    // [height][width]: where something is seen; other pixels are left out. Empty: everywhere.
    std::vector<bool> covered;
};

// Throws InputError for outputs of another size or unknown names; missing ones are not judged, but at least one must be
// there.
StageVerdict judge(const StageBinding& binding, const StageData& data, const std::vector<Dumped>& dumped,
                   const JudgeOptions& options);

}  // namespace plumb::parity
