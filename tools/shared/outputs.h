// The files of one run: all of them appear, or none does.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace plumb::cli {

// Files are written in a temporary folder inside the output folder and moved out of it when all are there. What was not
// committed is removed by the destructor, or by Ctrl-C; so are the folders that were made for it.
class Outputs {
  public:
    // Makes the folder where there is none. Throws InputError where it cannot be made or written to.
    explicit Outputs(const std::string& folder);
    ~Outputs();
    Outputs(const Outputs&) = delete;
    Outputs& operator=(const Outputs&) = delete;

    // Calls writer(path) with where to write the file that will be `name` in the output folder; `name` may lie in a
    // subfolder. An empty name stands for the folder itself. Errors name the place that the user knows.
    void write(const std::string& name, const std::function<void(const std::string& path)>& writer);

    void commit();

    // The committed files as people read them: "out/cornell.png"; sorted.
    const std::vector<std::string>& files() const { return files_; }

  private:
    std::filesystem::path folder_, temporary_;
    std::vector<std::filesystem::path> made_;  // folders, outermost first
    std::vector<std::string> files_;
};

// From now on Ctrl-C and SIGTERM remove the temporary folders and end the program with exit code 130. Called once,
// before there is any other thread.
void watch_signals();

// Never returns if the program is being interrupted: the error that this causes is not worth a message.
void wait_if_interrupted();

}  // namespace plumb::cli
