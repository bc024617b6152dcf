#include "pie/core/whole_file.h"

#include <unistd.h>

#include <fstream>
#include <string>
#include <system_error>

namespace pie {

namespace fs = std::filesystem;

std::optional<Error> writeWhole(const fs::path& target, std::string_view content) {
    const fs::path part = target.string() + "." + std::to_string(::getpid()) + ".part";
    std::error_code ignored;
    {
        std::ofstream file(part, std::ios::binary);
        file.write(content.data(), static_cast<std::streamsize>(content.size()));
        file.flush();
        if (!file) {
            file.close();
            fs::remove(part, ignored);
            return Error{target.string(), "", "cannot be written", "is the folder there, and is there room?"};
        }
    }
    std::error_code problem;
    fs::rename(part, target, problem);
    if (!problem) return std::nullopt;
    fs::remove(part, ignored);
    return Error{target.string(), "", problem.message(), ""};
}

} // namespace pie
