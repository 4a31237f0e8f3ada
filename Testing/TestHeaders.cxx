// SPDX-License-Identifier: BSD-3-Clause
// Nothing: a target needs a source, and its tests share the precompiled headers of it.
