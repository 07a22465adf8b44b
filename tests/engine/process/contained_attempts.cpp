// A program for a ContainedProcess that attempts what its input names and answers with a number: 0
// if it could, or an errno. The first word of the input names the limits: all, or those of one
// function; the second one the attempt, the third one a file.

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "process/contained_program.h"

namespace {

// Known before the limits hold.
int written_file = -1;
const pid_t parent = getppid();

/// 0, in a way that the compiler cannot follow.
volatile std::uintptr_t zero = 0;

std::int32_t error_of(long returned) { return returned < 0 ? errno : 0; }

std::int32_t map_code() {
    void* const code =
        mmap(nullptr, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return code == MAP_FAILED ? errno : 0;
}

std::int32_t count_descriptors() {
    std::int32_t count = 0;
    for (int d = STDERR_FILENO + 1; d < 256; ++d) count += fcntl(d, F_GETFD) >= 0 ? 1 : 0;
    return count;
}

std::int32_t count_variables() {
    std::int32_t count = 0;
    while (environ[count] != nullptr) ++count;
    return count;
}

/// The number of folders of LD_LIBRARY_PATH; 0 unless the last one is beside/, by its whole path.
std::int32_t count_library_folders() {
    const char* const variable = std::getenv("LD_LIBRARY_PATH");
    const std::string folders = variable != nullptr ? variable : "";
    const std::string last = folders.substr(folders.rfind(':') + 1);
    if (!last.starts_with('/') || !last.ends_with("/beside")) return 0;
    return static_cast<std::int32_t>(1 + std::count(folders.begin(), folders.end(), ':'));
}

std::int32_t attempt(const std::string& what, const std::string& file) {
    if (what == "nothing") return 0;
    if (what == "open") return error_of(open(file.c_str(), O_RDONLY));
    if (what == "create") return error_of(open((file + ".new").c_str(), O_WRONLY | O_CREAT, 0600));
    if (what == "write") return error_of(write(written_file, "x", 1));
    if (what == "read") return error_of(read(STDIN_FILENO, nullptr, 0));
    if (what == "socket") return error_of(socket(AF_INET, SOCK_STREAM, 0));
    if (what == "fork") return error_of(fork());
    if (what == "execute") return error_of(execl("/bin/true", "true", nullptr));
    if (what == "trace") return error_of(ptrace(PTRACE_PEEKDATA, parent, nullptr, nullptr));
    if (what == "signal") return error_of(kill(parent, 0));
    if (what == "code") return map_code();
    if (what == "descriptors") return count_descriptors();
    if (what == "environment") return count_variables();
    if (what == "library-folders") return count_library_folders();
    if (what == "memory") return std::vector<char>(aula::kContainedMemory_bytes)[zero];
    if (what == "crash") return *reinterpret_cast<volatile char*>(zero);
    if (what == "abort") std::abort();
    if (what == "compute") {
        while (zero == 0) continue;
    }
    return -1;
}

}  // namespace

int main() {
    const auto input = aula::map_input();
    std::istringstream words(
        std::string(reinterpret_cast<const char*>(input.data()), input.size()));
    std::string limits;
    std::string what;
    std::string file;
    words >> limits >> what >> file;
    if (!file.empty()) written_file = open((file + ".written").c_str(), O_WRONLY | O_CREAT, 0600);
    if (limits == "all") aula::contain();
    if (limits == "resources") aula::limit_resources(input.size(), 1);
    if (limits == "descriptors") aula::close_descriptors();
    if (limits == "files") aula::forbid_files();
    if (limits == "calls") aula::filter_calls();
    aula::write(attempt(what, file));
    std::_Exit(0);
}
