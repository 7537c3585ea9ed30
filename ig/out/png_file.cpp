// SPDX-License-Identifier: MIT
#include "ig/out/png_file.h"

#include <fmt/format.h>
#include <png.h>

#include <cassert>
#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>

namespace ig::out {
namespace {

constexpr uint64_t kMaxPixels = uint64_t{1} << 28;
// 15 ms for a 1280 x 720 picture on one core at 2.1 GHz; the higher levels cost a multiple of that.
constexpr int kCompressionLevel = 1;
constexpr int kFilter = PNG_FILTER_SUB;

struct CloseFile {
    void operator()(FILE* file) const noexcept { std::fclose(file); }
};

// libpng would print: keep its words for the error instead.
struct PngFailure {
    char words[128] = "";
};

void onPngError(png_structp png, png_const_charp words)
{
    auto* failure = static_cast<PngFailure*>(png_get_error_ptr(png));
    std::snprintf(failure->words, sizeof failure->words, "%s", words);
    longjmp(png_jmpbuf(png), 1);
}

void onPngWarning(png_structp, png_const_charp) {}

// Plain C inside: a longjmp passes over nothing that has a destructor.
bool encode(FILE* file, int widthPx, int heightPx, const std::byte* rgba, PngFailure& failure)
{
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &failure, onPngError, onPngWarning);
    if (!png) {
        std::snprintf(failure.words, sizeof failure.words, "out of memory");
        return false;
    }
    png_infop info = png_create_info_struct(png);
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        return false;
    }
    png_init_io(png, file);
    png_set_IHDR(png, info, static_cast<png_uint_32>(widthPx), static_cast<png_uint_32>(heightPx), 8,
                 PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png, kCompressionLevel);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, kFilter);
    png_write_info(png, info);
    png_set_filler(png, 0, PNG_FILLER_AFTER); // the fourth byte of a pixel is left out
    for (int row = 0; row < heightPx; ++row) {
        const std::byte* start = rgba + static_cast<size_t>(row) * static_cast<size_t>(widthPx) * 4;
        png_write_row(png, reinterpret_cast<png_const_bytep>(start));
    }
    png_write_end(png, nullptr);
    png_destroy_write_struct(&png, &info);
    return true;
}

} // namespace

Result<void> writePng(const std::string& path, int widthPx, int heightPx, std::span<const std::byte> rgba)
{
    assert(widthPx > 0 && heightPx > 0);
    assert(rgba.size() >= static_cast<size_t>(widthPx) * static_cast<size_t>(heightPx) * 4);
    const std::string part = path + ".part";
    const auto failed = [&](const char* what, const char* why) {
        std::remove(part.c_str());
        return fail(ErrorKind::failed, fmt::format("{}: cannot {}: {}", path, what, why));
    };
    std::unique_ptr<FILE, CloseFile> file(std::fopen(part.c_str(), "wb"));
    if (!file)
        return failed("create the picture", std::strerror(errno));
    PngFailure failure;
    errno = 0;
    if (!encode(file.get(), widthPx, heightPx, rgba.data(), failure))
        return failed("write the picture", errno != 0 ? std::strerror(errno) : failure.words);
    if (std::fclose(file.release()) != 0)
        return failed("write the picture", std::strerror(errno));
    if (std::rename(part.c_str(), path.c_str()) != 0)
        return failed("name the finished picture", std::strerror(errno));
    return {};
}

Result<Picture> readPng(const std::string& path)
{
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    const auto failed = [&](const std::string& why) {
        png_image_free(&image);
        return fail(ErrorKind::usage, fmt::format("{}: not a readable PNG picture: {}", path, why));
    };
    if (!png_image_begin_read_from_file(&image, path.c_str()))
        return failed(image.message);
    if (uint64_t{image.width} * image.height > kMaxPixels)
        return failed(fmt::format("{} x {} pixels are too many", image.width, image.height));
    image.format = PNG_FORMAT_RGBA;
    Picture picture;
    picture.widthPx = static_cast<int>(image.width);
    picture.heightPx = static_cast<int>(image.height);
    picture.rgba.resize(PNG_IMAGE_SIZE(image));
    if (!png_image_finish_read(&image, nullptr, picture.rgba.data(), 0, nullptr))
        return failed(image.message);
    return picture;
}

} // namespace ig::out
