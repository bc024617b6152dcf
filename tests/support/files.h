#pragma once
// Files that tests write and leave behind.

#include <filesystem>
#include <string>
#include <string_view>

namespace pie::test {

/// A folder of its own, removed with the object.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }
    /// Writes a file below the folder, with the folders above it; returns its path.
    [[nodiscard]] std::string write(const std::string& name, std::string_view content) const;

private:
    std::filesystem::path path_;
};

/// Content of a file; empty if it cannot be read.
[[nodiscard]] std::string readText(const std::filesystem::path& file);

/// Where pictures of failed tests go: $PIE_TEST_OUTPUT, else test-output in the build folder. Made when missing.
[[nodiscard]] std::filesystem::path outputFolder();

} // namespace pie::test
