#include "tools/shared/outputs.h"

#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

#include "core/error.h"
#include "io/file.h"
#include "tools/shared/command.h"

namespace plumb::cli {

namespace fs = std::filesystem;

namespace {

// The temporary folders that exist now, each with the folders that were made for it.
struct Pending {
    fs::path temporary;
    std::vector<fs::path> made;
};
struct Registry {
    std::mutex mutex;
    std::vector<Pending> pending;
    std::atomic<bool> interrupted{false};
};
// Never destroyed: the thread that waits for signals outlives main.
Registry& registry() {
    static Registry& r = *new Registry;
    return r;
}

void remove(const Pending& pending) {
    // A writer may still be adding files when Ctrl-C comes.
    std::error_code error;
    for (int attempt = 0; attempt < 1000 && fs::exists(pending.temporary, error); ++attempt)
        fs::remove_all(pending.temporary, error);
    // Only folders that are empty again go.
    for (auto folder = pending.made.rbegin(); folder != pending.made.rend(); ++folder) fs::remove(*folder, error);
}

}  // namespace

Outputs::Outputs(const std::string& folder) : folder_(folder.empty() ? "." : folder) {
    std::error_code error;
    if (fs::exists(folder_, error) && !fs::is_directory(folder_, error))
        throw InputError(folder_.string(), "", "is a file; expected a folder to write to");
    std::lock_guard lock(registry().mutex);
    for (fs::path p = folder_; !p.empty() && !fs::exists(p, error); p = p.parent_path()) made_.push_back(p);
    std::reverse(made_.begin(), made_.end());
    fs::create_directories(folder_, error);
    std::string name = (folder_ / ".plumb-XXXXXX").string();
    if (error || !mkdtemp(name.data())) {
        const std::string cause = error ? error.message() : std::error_code(errno, std::generic_category()).message();
        remove({{}, made_});
        throw InputError(folder_.string(), "", "cannot write to this folder: " + cause);
    }
    temporary_ = name;
    registry().pending.push_back({temporary_, made_});
}

Outputs::~Outputs() {
    wait_if_interrupted();
    std::lock_guard lock(registry().mutex);
    auto& pending = registry().pending;
    const auto mine =
        std::find_if(pending.begin(), pending.end(), [&](const Pending& p) { return p.temporary == temporary_; });
    remove(*mine);
    pending.erase(mine);
}

void Outputs::write(const std::string& name, const std::function<void(const std::string& path)>& writer) {
    std::error_code error;
    fs::create_directories((temporary_ / name).parent_path(), error);
    try {
        writer(name.empty() ? temporary_.string() : (temporary_ / name).string());
    } catch (const InputError& e) {
        std::string message = e.what();
        const std::size_t at = message.find(temporary_.string());
        if (at != std::string::npos) message.replace(at, temporary_.string().size(), folder_.string());
        throw InputError(message);
    }
}

void Outputs::commit() {
    wait_if_interrupted();
    // Ctrl-C waits until all files are in place.
    std::lock_guard lock(registry().mutex);
    std::vector<fs::path> names;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(temporary_))
        if (entry.is_regular_file()) names.push_back(entry.path().lexically_relative(temporary_));
    std::sort(names.begin(), names.end());

    // What is in the way is found before the first file is moved.
    std::error_code error;
    for (const fs::path& name : names) {
        const fs::path target = folder_ / name;
        if (fs::is_directory(target, error))
            throw InputError(target.string(), "", "cannot write: a folder has its name");
        fs::create_directories(target.parent_path(), error);
        if (error) throw InputError(target.parent_path().string(), "", "cannot make this folder: " + error.message());
    }
    for (const fs::path& name : names) {
        const fs::path target = folder_ / name;
        fs::rename(temporary_ / name, target, error);
        if (error) throw InputError(target.string(), "", "cannot write: " + error.message());
        files_.push_back(target.lexically_normal().string());
    }
}

void watch_signals() {
    // A signal that the caller chose to ignore (nohup) stays ignored.
    sigset_t signals;
    sigemptyset(&signals);
    for (int signal : {SIGINT, SIGTERM}) {
        struct sigaction action;
        sigaction(signal, nullptr, &action);
        if (action.sa_handler != SIG_IGN) sigaddset(&signals, signal);
    }
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    registry();
    std::thread([signals] {
        int signal = 0;
        while (sigwait(&signals, &signal) != 0) {
        }
        Registry& r = registry();
        r.interrupted = true;
        std::lock_guard lock(r.mutex);
        for (const Pending& pending : r.pending) remove(pending);
        io::remove_unfinished_files();
        if (isatty(STDERR_FILENO)) (void)!write(STDERR_FILENO, "\r\033[K", 4);
        _exit(interrupted);
    }).detach();
}

void wait_if_interrupted() {
    while (registry().interrupted) pause();
}

}  // namespace plumb::cli
