#pragma once
// The trees that a Vfs lays over each other. Names given to a source are safe ones (names.h): lower case, '/'.
// All calls may come from several threads at once.

#include "pie/core/result.h"
#include "pie/level/vfs.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace pie::level {

class FileSource {
public:
    FileSource() = default;
    FileSource(const FileSource&) = delete;
    FileSource& operator=(const FileSource&) = delete;
    FileSource(FileSource&&) = delete;
    FileSource& operator=(FileSource&&) = delete;
    virtual ~FileSource() = default;

    [[nodiscard]] virtual bool contains(const std::string& name) const = 0;
    /// Where the file is, for messages; only for names it contains.
    [[nodiscard]] virtual std::string origin(const std::string& name) const = 0;
    [[nodiscard]] virtual Result<Bytes> read(const std::string& name) const = 0;
    /// Names below `folder` ("" or "a/b/") that end in `suffix`, in the source's own order.
    [[nodiscard]] virtual std::vector<std::string> list(const std::string& folder, const std::string& suffix) const = 0;
};

/// Files larger than this are refused: no level or picture comes near it, a damaged or hostile archive may claim it.
inline constexpr std::uintmax_t maxFileBytes = std::uintmax_t{1} << 30;

[[nodiscard]] Result<Bytes> readWholeFile(const std::filesystem::path& path);

[[nodiscard]] std::shared_ptr<const FileSource> makeFolderSource(const std::filesystem::path& folder);
[[nodiscard]] Result<std::shared_ptr<const FileSource>> makeArchiveSource(const std::filesystem::path& pk3);
[[nodiscard]] std::shared_ptr<const FileSource> makeMemorySource(std::string name,
                                                                 std::vector<std::pair<std::string, Bytes>> files);

} // namespace pie::level
