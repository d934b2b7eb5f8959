"""What people look at: trees as pictures, terminal and full-screen views, HTML reports, videos."""
