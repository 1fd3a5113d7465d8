// plumb stages: every stage that exists.
#include <memory>
#include <nlohmann/json.hpp>

#include "gi/frame/frame.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/reports.h"

namespace plumb::cli {

void add_stages(CLI::App& program, Action& action) {
    auto common = std::make_shared<Common>();
    CLI::App* command = program.add_subcommand("stages", "list every stage: inputs, outputs, parameters, twin, source");
    add_common(*command, *common);
    command->callback([common, &action] {
        action = [common] {
            common->run_options();
            const std::vector<StageInfo> stages = frame::all_stages();
            const std::string text = common->json ? json_text(stages_json(stages)) : stages_text(stages);
            std::fputs(text.c_str(), stdout);
            return int(success);
        };
    });
}

}  // namespace plumb::cli
