#include "tests/support/program.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace aula::test {

std::vector<std::string> names_in(const std::filesystem::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

std::string read_file(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

Program::Program(const std::vector<std::string>& command) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    constexpr int kCreate = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, (folder_.path() / "out").c_str(),
                                     kCreate, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, (folder_.path() / "err").c_str(),
                                     kCreate, 0600);
    std::vector<char*> arguments;
    for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    const int error =
        posix_spawnp(&pid_, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw std::runtime_error("cannot run " + command[0]);
}

void Program::signal(int number) const { kill(pid_, number); }

bool Program::running() {
    if (!ended_) ended_ = waitpid(pid_, &wait_status_, WNOHANG) == pid_;
    return !ended_;
}

std::string Program::err() const { return read_file(folder_.path() / "err"); }

ProgramResult Program::wait() {
    if (!ended_) waitpid(pid_, &wait_status_, 0);
    ended_ = true;
    const int status =
        WIFEXITED(wait_status_) ? WEXITSTATUS(wait_status_) : 128 + WTERMSIG(wait_status_);
    return {status, read_file(folder_.path() / "out"), err(), WIFSIGNALED(wait_status_)};
}

ProgramResult run_program(const std::vector<std::string>& command) {
    return Program(command).wait();
}

bool are_installed(const std::string& programs) {
    return run_program({"sh", "-c", "for p in " + programs + "; do command -v $p || exit 1; done"})
               .status == 0;
}

}  // namespace aula::test
