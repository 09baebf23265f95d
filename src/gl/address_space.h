#pragma once

/// Where the process has a limit on its addresses (ulimit -v), software drivers do not survive an allocation that fails:
/// Mesa's and LLVM's threads abort, dereference null, or wait for ever for one another.
namespace dapple::gl {

/// Throws UsageError if the limit leaves less than a software driver needs for its threads. Else, with a limit, sees to it
/// that a crash ends with one line and exit code 5.
void guardAddressSpace();

/// Whether objects are better left to the end of the process: an exception unwinds, and the limit may be why.
bool leaveObjects();

}  // namespace dapple::gl
