#pragma once
// A camera's GenICam description, looked at before the library evaluates it: it comes from whatever answers at the
// camera's address, and what the library would follow, allocate or recurse into without end is refused here. Pure.
#include <string>
#include <string_view>

namespace rotunda::capture {

// Where a GigE Vision device says that its description lies: "Local:name.xml;address;size", both numbers hexadecimal.
// Empty: it may be followed; otherwise why not. Files and web pages are not followed: they would be this machine's, or
// anybody's.
std::string url_problem(std::string_view url);

// Of the description itself (GenICam standard, GenApi 2.1): empty if it may be evaluated, else why not. It must be XML
// of a sensible size, and the values of its nodes must be computable: none needs itself, and none takes more steps than
// any camera's.
std::string description_problem(std::string_view xml);

}  // namespace rotunda::capture
