// What the C library of macOS declares and that of Linux does not, as far as Aula uses it; for
// ../for_macos. After the manual pages of macOS: renamex_np(2), fcntl(2), fsync_volume_np(2),
// posix_spawnattr_setflags(3).
#pragma once

#include <sys/mman.h>

#undef MADV_HUGEPAGE

#define F_FULLFSYNC 51
#define RENAME_SWAP 0x2
#define RENAME_EXCL 0x4
#define SYNC_VOLUME_FULLSYNC 0x01
#define SYNC_VOLUME_WAIT 0x02
#define POSIX_SPAWN_CLOEXEC_DEFAULT 0x4000

extern "C" int renamex_np(const char* from, const char* to, unsigned flags);
extern "C" int fsync_volume_np(int descriptor, int flags);
