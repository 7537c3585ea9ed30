// SPDX-License-Identifier: MIT
#include "hostif/messages.h"

#include <algorithm>

namespace hostif {

FixedText::FixedText(std::string_view text) noexcept
    : _size(static_cast<uint8_t>(std::min({text.size(), text.find('\0'), kCapacity})))
{
    std::copy_n(text.begin(), _size, _bytes.begin());
}

} // namespace hostif
