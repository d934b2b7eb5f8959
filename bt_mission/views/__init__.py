"""Views: trees as drawings, terminal and full-screen views, HTML reports, videos."""
