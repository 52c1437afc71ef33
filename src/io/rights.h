/* SPDX-License-Identifier: Apache-2.0 */
/* The rights of a file that takes another's place: nobody may do more with the new file than with the old one. */
#ifndef CELLWALK_IO_RIGHTS_H
#define CELLWALK_IO_RIGHTS_H

#include <stdbool.h>
#include <sys/stat.h>

/* Gives the new file fd the owner, group, access control list and permissions of the old one. Set-user-ID, set-group-ID
 * and sticky bits are never kept. Where the group or the list cannot be, group and others get the permissions that both
 * had. False if the owner cannot be kept: then nothing of the old file's rights has a meaning for the new one. */
bool io_rights_keep(int fd, const char *old_path, const struct stat *old);

#endif
