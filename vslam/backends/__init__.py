"""The SLAM back-ends, one file each; a back-end is known because its module lies in this folder."""
