// What the documentation says of the program is what the program says of itself: the table of commands, the options and
// settings in command blocks, and every link to a file.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "tests/program/program.h"

using namespace plumb::program;
namespace fs = std::filesystem;

namespace {

const fs::path root = PLUMB_SOURCE_DIR;

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

// The documentation: no build folder's, no hidden one's.
std::vector<fs::path> markdown_files() {
    std::vector<fs::path> files;
    for (fs::recursive_directory_iterator at(root), end; at != end; ++at) {
        const std::string name = at->path().filename();
        if (at->is_directory() && (at->is_symlink() || name.front() == '.' || name.rfind("build", 0) == 0))
            at.disable_recursion_pending();
        else if (at->path().extension() == ".md")
            files.push_back(at->path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

struct Command {
    std::string name, description;
};

// The list under "Subcommands:" of a help text.
std::vector<Command> commands_of(const std::string& help) {
    std::vector<Command> commands;
    bool inside = false;
    for (const std::string& line : lines_of(help)) {
        if (line == "Subcommands:") inside = true;
        else if (inside && line.rfind("  ", 0) != 0) break;
        else if (inside) {
            std::istringstream words(line);
            Command c;
            words >> c.name >> std::ws;
            std::getline(words, c.description);
            commands.push_back(c);
        }
    }
    return commands;
}

std::string table_of(const std::vector<Command>& commands) {
    std::string table = "| command | does |\n|---|---|\n";
    for (const Command& c : commands) table += "| `plumb " + c.name + "` | " + c.description + " |\n";
    return table;
}

// GitHub's name of a heading: lower case, spaces are hyphens, punctuation is gone.
std::string anchor_of(const std::string& heading) {
    std::string anchor;
    for (const char c : heading.substr(heading.find_first_not_of("# ")))
        if (c == ' ') anchor += '-';
        else if (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' || (c & 0x80))
            anchor += char(std::tolower(static_cast<unsigned char>(c)));
    return anchor;
}

bool has_anchor(const fs::path& file, const std::string& anchor) {
    for (const std::string& line : lines_of(read(file)))
        if (line.rfind('#', 0) == 0 && anchor_of(line) == anchor) return true;
    return false;
}

// What follows "](" up to its ")", outside of code.
std::vector<std::string> links_of(const std::string& text) {
    std::vector<std::string> links;
    for (const std::string& line : lines_of(text)) {
        if (line.rfind("    ", 0) == 0) continue;
        bool code = false;
        for (std::size_t i = 0; i < line.size(); ++i) {
            if (line[i] == '`') code = !code;
            if (code || line.compare(i, 2, "](") != 0) continue;
            links.push_back(line.substr(i + 2, line.find(')', i) - i - 2));
        }
    }
    return links;
}

// Words of the command blocks that call the program, without comments.
std::vector<Words> calls_of(const std::string& text) {
    std::vector<Words> calls;
    for (const std::string& line : lines_of(text)) {
        if (line.rfind("    ", 0) != 0) continue;
        std::istringstream stream(line);
        Words words;
        for (std::string word; stream >> word && word != "#" && word != "|" && word != ">";) {
            const bool quoted = word.size() > 1 && word.front() == '"' && word.back() == '"';  // as a shell takes it
            words.push_back(quoted ? word.substr(1, word.size() - 2) : word);
        }
        if (!words.empty() && (words[0] == "plumb" || words[0] == "build/release/plumb")) calls.push_back(words);
    }
    return calls;
}

// The help of a command, or of a command's command: asked once.
const std::string& help_of(const Words& names) {
    static std::map<Words, std::string> asked;
    const auto found = asked.find(names);
    if (found != asked.end()) return found->second;
    Words words = names;
    words.push_back("--help");
    const Result r = run(words);
    return asked[names] = r.exit == 0 ? r.out : std::string();
}

// The options that a help text lists.
std::set<std::string> options_of(const std::string& help) {
    std::set<std::string> options;
    for (const std::string& line : lines_of(help)) {
        if (line.rfind("  -", 0) != 0) continue;
        const std::string names = line.substr(2, line.find(' ', 2) - 2);  // "-o,--output"
        std::istringstream stream(names);
        for (std::string name; std::getline(stream, name, ',');) options.insert(name);
    }
    return options;
}

// The names that the program takes beside its options.
struct ProgramNames {
    std::set<std::string> stages;
    std::string scene;  // that settings are tried on
    std::map<std::string, std::string> refused;  // settings that were tried: why not, or empty
};
ProgramNames program_names() {
    ProgramNames names;
    for (const Json& stage : Json::parse(run({"stages", "--json"}).out)) names.stages.insert(stage.at("name").get<std::string>());
    names.scene = small_scene(fresh_folder("readme"));
    return names;
}

// Whether --set takes it, or --vary its first value.
std::string refusal_of(const std::string& setting, ProgramNames& names) {
    const auto found = names.refused.find(setting);
    if (found != names.refused.end()) return found->second;
    const Result r = run({"plan", names.scene, "--set", setting});
    return names.refused[setting] = r.exit == 0 ? "" : r.err;
}

// What is wrong with a call; empty: nothing.
std::string fault_of(const Words& call, ProgramNames& names) {
    if (call.size() < 2) return "no command";
    Words command = {call[1]};
    std::size_t at = 2;
    const std::vector<Command> inner = commands_of(help_of(command));
    if (!inner.empty() && at < call.size() && call[at].front() != '-') command.push_back(call[at++]);
    const std::string& help = help_of(command);
    if (help.empty()) return "no such command: " + command.back();
    const std::set<std::string> options = options_of(help);
    for (; at < call.size(); ++at) {
        const std::string name = call[at].substr(0, call[at].find('='));
        if (name.size() < 2 || name.front() != '-' || std::isdigit(static_cast<unsigned char>(name[1]))) continue;
        if (!options.count(name)) return "no such option: " + name;
        if (at + 1 == call.size()) continue;
        const std::string& value = call[at + 1];
        if (name == "--stage" && value != "all" && !names.stages.count(value)) return "no such stage: " + value;
        if (name == "--set") {
            if (const std::string refusal = refusal_of(value, names); !refusal.empty()) return refusal;
        } else if (name == "--vary") {
            if (const std::string refusal = refusal_of(value.substr(0, value.find(',')), names); !refusal.empty())
                return refusal;
        }
    }
    return "";
}

}  // namespace

TEST_CASE("readme: the table of commands is that of --help", "[program][readme]") {
    const std::vector<Command> commands = commands_of(help_of({}));
    REQUIRE(commands.size() > 10);
    for (const Command& c : commands) {
        INFO(c.name);
        CHECK(c.description.size() > 20);  // a sentence, not the command's name again
    }
    const std::string text = read(root / "README.md"), begin = "<!-- commands: ", end = "<!-- end of commands -->";
    const std::size_t first = text.find('\n', text.find(begin)) + 1, last = text.find(end);
    REQUIRE(text.find(begin) != std::string::npos);
    REQUIRE(last != std::string::npos);
    INFO("Put this table between the two comments \"commands\" of README.md:\n\n" << table_of(commands));
    CHECK(text.substr(first, last - first) == "\n" + table_of(commands) + "\n");
}

TEST_CASE("readme: every link to a file or a heading leads there", "[program][readme]") {
    std::size_t followed = 0;
    for (const fs::path& file : markdown_files())
        for (const std::string& link : links_of(read(file))) {
            if (link.find("://") != std::string::npos) continue;
            INFO(fs::relative(file, root).string() << ": " << link);
            const std::size_t hash = link.find('#');
            const fs::path target = hash == 0 ? file : file.parent_path() / link.substr(0, hash);
            CHECK(fs::exists(target));
            if (hash != std::string::npos) CHECK(has_anchor(target, link.substr(hash + 1)));
            ++followed;
        }
    CHECK(followed > 50);
    CHECK(has_anchor(root / "README.md", "is-my-shader-right"));
    CHECK_FALSE(has_anchor(root / "README.md", "is-my-shader-wrong"));
}

TEST_CASE("readme: examples read files of the repository, or what an example before them has written", "[program][readme]") {
    // A reader's own, and what a line of the block makes that is no call of the program.
    const std::set<std::string> own = {"scene.toml", "FOLDER/manifest.toml", "dumps/manifest.toml", "out/small_rsm_96x57/manifest.toml", "room.toml", "room.glb", "baked.exr"};
    std::size_t read_files = 0;
    for (const char* page : {"README.md", "tools/plumb/README.md"}) {
        std::set<std::string> made = own;
        for (const Words& call : calls_of(read(root / page))) {
            const auto output = std::find_if(call.begin(), call.end(), [](const std::string& w) { return w == "-o" || w == "--output"; });
            const std::string folder = output == call.end() || output + 1 == call.end() ? "" : output[1];
            for (std::size_t i = 2; i < call.size(); ++i) {
                const std::string ending = fs::path(call[i]).extension();
                const bool written = call[i] == folder || std::set<std::string>{"--html", "--junit", "--export-sh", "--error"}.count(call[i - 1]);
                if (written || !std::set<std::string>{".toml", ".glb", ".json", ".exr"}.count(ending)) continue;
                INFO(page << ": " << call[1] << " " << call[i]);
                CHECK((made.count(call[i]) > 0 || fs::exists(root / call[i])));
                ++read_files;
            }
            if (folder.empty()) continue;
            if (call[1] == "make-scene") made.insert(folder + "/" + call[2] + ".toml");
            if (call[1] == "export") made.insert(folder + "/manifest.toml");
            if (call[1] == "render") made.insert(folder + "/" + fs::path(call[2]).stem().string() + ".exr");
            if (call[1] == "sweep") made.insert(folder + "/sweep.json");
        }
    }
    CHECK(read_files > 30);
}

TEST_CASE("readme: command blocks name commands, options, stages and settings that there are", "[program][readme]") {
    ProgramNames names = program_names();
    std::size_t checked = 0;
    for (const fs::path& file : markdown_files())
        for (const Words& call : calls_of(read(file))) {
            std::string line;
            for (const std::string& word : call) line += word + " ";
            INFO(fs::relative(file, root).string() << ": " << line);
            CHECK(fault_of(call, names) == "");
            ++checked;
        }
    CHECK(checked > 40);
    // What is not there is found.
    CHECK(fault_of({"plumb", "rendr", "x"}, names) != "");
    CHECK(fault_of({"plumb", "render", "x", "--trhuth"}, names) != "");
    CHECK(fault_of({"plumb", "experiment", "vrsm", "--view", "8"}, names) != "");
    CHECK(fault_of({"plumb", "explain", "x", "--stage", "no.stage"}, names) != "");
    CHECK(fault_of({"plumb", "render", "x", "--set", "rsm.smaples=3"}, names) != "");
}
