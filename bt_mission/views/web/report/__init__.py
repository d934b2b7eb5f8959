"""A recorded run as one page: the page of the browser view with its data inside."""
